#pragma once

#include <cstddef>

/// Every tuned number of the solver: its unit, what it trades, and what set it. "Suite" is `atoll verify --stability`;
/// most were also moved by four both ways with it and with ten built-in scenes, and where nothing moved that is said.
/// Numbers that a method or a paper gives, and grains of parallel loops, stay where they are used.
namespace atl::solver::tuning {

// --- Soft contacts and joints in sweeps

/// By the substep rate: frequency of contacts. Twice of it is 4 times as stiff, but a pyramid of 22 layers drifts by 55
/// mm instead of 10; half of it lets a wide wall sink by 0.58 m instead of 42 mm.
inline constexpr double contact_hertz_share = 0.125;
/// The most that may be asked for: from 1 on, stacks of soft contacts drift off.
inline constexpr double contact_hertz_limit = 0.25;
/// By the substep rate, of joints that are swept. Of an error, let a sweep take away a small part e, n sweeps with
/// softness push and r relax: it rings up from x^2 = 1 + r / n on, with x the angular frequency by the substep rate, or
/// from 0.286 on with one sweep and two (a net of balls from 0.4). Of 300 random mechanisms 9 gain energy with 0.3, and
/// 4 with 0.275 or 0.25; ragdolls are open by 0.38, 0.41 and 0.54 mm.
inline constexpr double joint_hertz_limit = 0.28;
/// Relaxing sweeps over joints, for each that is asked for. With one 19 of these mechanisms gain energy at 0.275, with
/// three as many as with two.
inline constexpr int joint_relaxations = 2;
/// The least part of a row's response J M^-1 J^T that is left while its joint holds. A row of which less is left would
/// act by single precision's rounding, and stays as it is.
inline constexpr double least_held = 1e-5;
/// m or rad: what a locked coordinate is brought back by in a substep at most. Without, hinges whose axes are put apart
/// close at 248 rad/s; with an eighth of it a servo's arm gets nine tenths of the torque. And how far a free coordinate
/// is within its range where it needn't be ready to act.
inline constexpr double most_closed = 0.1;

/// How far soft contacts may give under what they carry, in parts of the smaller body's half thickness, before they
/// stiffen. `pile` overlaps by 10.6 mm in the mean without, by 4.6 and 3.3 with 1% and half a percent, in the same
/// time. A wall of 50 boxes then sinks by 8 cm instead of 17, and drifts by 25 instead of 5, which it doesn't with 2%.
inline constexpr double stiffening_penetration = 0.01;
/// With 2, 4 and 16 `pile` overlaps by 6.3, 5.0 and 4.5 mm in the mean, with 8 by 4.6.
inline constexpr float most_stiffening = 8;
/// rad a step: contacts of a body that turns by more are where they will be half way through it.
inline constexpr double least_turn = 1e-5;
/// rad a step, up to which a body is taken to turn on as it does: the part of the half turn that contacts are moved by
/// falls with its fourth power. With 1 a top of 50 rad/s, whose nutation no step of 1/60 s sees, falls over (an error
/// of 1.2 instead of 0.27, relative to its tilt); with 0.25 or 0.5 what rolls is the same.
inline constexpr double known_turn = 0.25;
/// rad a step, times the root of the largest moment of inertia over the least: a body may turn by that before what its
/// contacts know of it is told of another one. See PassiveEnergy. Of 120 rods that fall on the ground and turn by 1.1
/// rad a step none gains a thousandth of its energy, of 120 that turn by 1.6 four do.
inline constexpr double blind_turn = 1;
/// The square of the sine of the angle between a round body's axis and a normal, at least: what lies flat is touched at
/// no single point, which would move along its rim as far as it likes.
inline constexpr double least_lean = 0.01;
/// (m/s)^2: where gravity times the size of what is touched, in m from its centre of mass, is more than this, the push
/// speed grows by its root. Boxes of a metre come to half of it on Earth. Without, boxes of a kilometre overlap by a
/// tenth.
inline constexpr double usual_drop = 9.81;
/// m/s: a contact that closes faster gets more rounds over its points, or a body that lands flat is left turning. A box
/// of 1 m dropped flat from 3 m slides by 0.05 mm instead of 15, from 10 m by 4 mm instead of 150. At an eighth, what
/// merely moves gets them too: a piston's load is thrown at 15 m/s.
inline constexpr float landing_speed = 0.5f;
/// m/s, to or from each other, from which on all points of a contact are first changed at once. With 0.05 and 0.25 a
/// box dropped flat from 2.5 m ends 7 um aside, without it 3.7 mm. At 0.05 a column that a belt takes along leans.
inline constexpr float spread_speed = 0.25f;
/// Over the points of each contact that lands. With one, hopper overlaps by twice as much; with 28 a coin's landing is
/// farther off.
inline constexpr int landing_rounds = 7;
/// Of the speed that gravity gives in a substep: slower impacts don't bounce where nothing else is asked for. With 1,
/// what lies is noise; a ball of restitution 0.8 that falls from 1 m comes to rest after 3.95 s with 2, with 25
/// after 3.3, and by its closed form after 4.06.
inline constexpr double least_bounce = 2;

/// Rounds in which a blow is passed on among what touches, within a substep; the rest waits for the next. A row of 40
/// balls takes 40. With 8, boxes that fall in a heap take 5% less time.
inline constexpr int most_impact_rounds = 64;
/// Sweeps over what hits together in a round, and the part of its fastest speed that the last one may change. A rack of
/// 15 balls parts as symmetric as 5e-11 m/s of 8 with these, 1e-13 with 1000 and 1e-13. 1000 boxes of restitution 0.1
/// that fall in a heap take 2.5 ms a step, 2.9 with 50, and 5.8 and more with 1000.
inline constexpr int most_impact_sweeps = 20;
inline constexpr double impact_tolerance = 1e-10;

/// Sweeps over a group's joints in a substep in which some coordinate bounces at the end of its range.
inline constexpr int joint_bounce_sweeps = 16;

/// rad/s: what spins slower does not tumble to speak of (its square is an angular acceleration), and a pile at rest
/// need not pay for it. Not by the turn in a substep, or finer steps would be worse.
inline constexpr double least_spin = 0.02;

// --- Joints

/// Of the force in a joint, by which the one that stiffness is made of follows it in a substep, or in a step where
/// joints are swept: what light links pull is noise. A chain of 100 links with 100,000 times the mass at its end opens
/// by 24 mm with 1, and by a nanometre with 0.2; one of 1,000,000 times breaks with 0.8.
inline constexpr double tension_smoothing = 0.2;
/// m/s or rad/s: the fastest that a coordinate is brought back into its range. As contacts' push speed by default.
inline constexpr double closing_speed = 3;
/// rad: joints whose arms swing by more in a substep are brought back after it alone. Ten rods that whip at 1/3 rad
/// keep their energy to 60% so, and to 800% without a limit.
inline constexpr double most_bend = 0.1;
/// rad/s: slower ones bend by too little to be looked at. With 0.1 small swings are no longer of second order.
inline constexpr double least_bend_spin = 1e-3;
/// The part of its rate that a damper takes from two bodies alone in a substep, from which on it counts what all joined
/// bodies weigh. Without that the wrist of a Shadow hand, whose bodies are light and carry the fingers, is off by 9e-4 rad
/// after a second at 1/240, with it by 7e-5. Likewise of servos a humanoid takes 1.4 times as long, and is off by as
/// much.
inline constexpr double notable_decay = 0.3;
/// m or rad: gaps that one Newton step has left are closed by more. At a hundredth the chatter of loads on a bridge
/// grows by 4%, at a hundred times energy does.
inline constexpr double open_gap = 1e-4;
/// m or rad: what displacements in single precision leave open at the end of a step is closed, in double, if it is
/// more. With 1e-7 ragdolls of joints that are solved at once ended steps 1e-8 m apart.
inline constexpr double settled_gap = 1e-9;
/// m or rad: what closes joints moves no body farther than this, or rows are near where they are singular.
inline constexpr double far_at_rest = 0.3;
/// Rounds of finding out which limits, motors and springs hold in one substep. With 3, ragdolls overlap twice as much;
/// with 48 nothing moved. What doesn't settle then is found by Newton's method.
inline constexpr int mode_rounds = 12;
/// By how much locks give, in parts of an effective mass's inverse, where joints make loops and nothing touches them:
/// loops ask for the same twice. Eight windows in a row, whose rods come to lie in a line twice a turn, are off by
/// 0.03% of their energy with it, and by 6.6% with the compliance of others.
inline constexpr double compliance_of_loops = 1e-6;
/// By how much locks give where joints make no loops: no more than lets two that ask for the same share it.
inline constexpr double compliance_of_trees = 1e-10;

/// No solve of joints adds more than this part to the kinetic energy, beyond what springs and motors do, or it is made
/// again such that it can't. Without it 2 of 400 random mechanisms gain a twentieth of their energy, with it none; the
/// scenes of the suites for stability and physics come to it 10 times in all.
inline constexpr double energy_tolerance = 1e-3;
/// By which part of the energy that springs and servos give to motion in a step, or take, motion may be off, where
/// joints touch something. A leg that jumps by a servo of 45 rad/s at steps of 1/60 s comes up to 92% of its height
/// with 0.
inline constexpr double exchange_tolerance = 0.1;
/// By which part the energy of what moves in joints is changed at most in a step, to what it should be: see
/// Conservation. With 0.05 three rods that whip lose all of theirs in 100 s at the default step, with 0.5 none.
inline constexpr double most_energy_restored = 0.5;
/// Part of an island's fastest speed: if joints part faster than that when a step begins, something has struck the
/// island. Closed gaps leave a tenth of it.
inline constexpr double most_parting = 1e-3;
/// rad: where an arm swings by more in a substep, energy is left as it is. With 0.1 ten rods that are let go level lose
/// 43% of theirs in 100 s at the default step.
inline constexpr double most_resolved_swing = 0.3;
/// J/kg: less is rounding.
inline constexpr double least_energy = 1e-12;
/// m/s or rad/s, and of the rate: a motor that is farther from its speed as a step begins has been pulling with all it
/// has. Rates are in single precision within a step. Not tried otherwise.
inline constexpr double motor_behind = 1e-5;

/// Cosine of half the swing, from which on a twist fades: it is that of 120 degrees. Not tried otherwise.
inline constexpr double fading_twist = 0.5;
/// Cosine of half the turn, from which on a turn of three fades: it is that of 151 degrees, at which the coordinate is
/// 1.94 of its 2. Not tried otherwise.
inline constexpr double fading_turn = 0.25;

// --- Which islands are solved how

/// The default budget of errors: how far soft contacts may give under what they carry, in parts of the smaller body's
/// half thickness, before they count as overloaded. A column of boxes starts to buckle from about 15 boxes on, where it
/// is 1.6% (by Euler's load; a longer one takes a while). At four times a wide wall sinks by 0.7 m; at a quarter a wall
/// of 50 boxes takes 2.3 times as long, and sinks by 10 mm instead of 167.
inline constexpr double overload_penetration = 0.015;
/// In islands that are little but columns, which cost little to solve at once: five boxes. With 0.5%, six, stacks of
/// five overlap by 2.2 mm, which five of the suite's criteria don't allow; with 0.4% what lands on a stack of three is
/// taken for a load. At four times columns of ten and arches fall. At a quarter it would take in stacks of two, which
/// in a crowd then take three times as many instructions a step.
inline constexpr double column_penetration = 0.0043;
/// Contacts a body, of what is little but columns or arches. At a quarter these are no longer known; at four times the
/// contents of a piston are.
inline constexpr double contacts_of_columns = 1.5;
/// In parts of the arm: what overlaps so far counts as deep. A quarter of it makes hopper 2.4 times as dear, four times
/// moves nothing; without any a heavy box sinks through four small ones.
inline constexpr double deep_penetration = 0.12;
/// A body that is so many times as heavy as a joined one it presses on counts as deep in it: by more than limbs of a
/// body differ. With 10, a hundred ragdolls take six times as long.
inline constexpr double deep_ratio = 64;
/// Substeps of a step, as of which contacts count as soft when it is decided whether they carry too much: with more
/// they are stiffer, but to decide by that would leave a wall to eight, and sink by 165 mm, that gets sixteen if four
/// are asked for, and sinks by 41. Nor do sweeps settle columns any sooner: with 16 a tower of 50 boxes falls that
/// gives by 0.3% only.
inline constexpr double usual_substeps = 4;
/// Of a contact's arm: how far a body counts as reaching along the normal at least, of what is touched at a rim. At
/// four times card houses sag, at a quarter nothing moved.
inline constexpr double least_thickness = 0.1;
/// Of the normal against up: what leans farther out holds nothing up, when loads are estimated. A quarter of it moved
/// nothing.
inline constexpr double least_slope = 0.3;
/// Steps from one estimate of the loads in an island to the next, while its bodies stay the same. With 1 pyramids take
/// 5% longer, and with 4 they take 1%.
inline constexpr int load_interval = 4;
/// s, for which what could not be solved at once is swept. 4000 boxes on plates that shake try in vain 616 times in 200
/// steps with 0.5, 247 times with 2, and take three quarters of the time.
inline constexpr float failed_time = 2;
/// Finer substeps are for what is built to stand and sags of its own weight, in so large a part. A few small stones
/// under large ones are not worth them, nor is a heap that has found its rest on soft contacts: to stiffen them stirs
/// it. With a quarter of it, walls of 50 boxes are among them, at 2.2 times the time.
inline constexpr double part_of_island = 0.25;
/// s, the longest substep of what sags: a wall of 100 layers sinks by 165 mm with twice of it, and by 41 with it; with
/// a quarter what is squeezed gets out.
inline constexpr double refined_substep = 1.0 / 960;
/// Substeps for one where a body lands that leans on something. Tilts of a block that rocks are off by 12% with 1,
/// by 3.4 with 4, by 2.5 with 8 and by 1.5 with 16; in 6% more time with 8, in 12 with 16.
inline constexpr int landing_refinement = 8;
/// Of an island that is solved at once: more take longer than a step may.
inline constexpr std::size_t most_bodies = 400;
/// The most that a body may weigh of a joined one it lies on, where joints and contacts take turns: boxes of 10 times a
/// plank's weight bounce off a bridge at 2.3 m/s, of 30 times at 4, where 0.9 is right.
inline constexpr double light_ratio = 10;
/// Of an error, by a sweep over two joints that hold a body to others: the largest eigenvalue of J1 J2^T J2 J1^T, with
/// rows scaled by J M^-1 J^T of each joint. Two heavy wheels on a light bar ring up, from 34 J to 230 kJ in 5 s, where
/// it is 0.78, and don't at 0.77 and below. Chains of hinged capsules, which don't either, come to 0.74; to solve them
/// at once as well takes 3.4 times as long.
inline constexpr double most_left = 0.76;
/// Joints, of the longest way through them that joints solved one by one hold. 3 or 48 moved nothing.
inline constexpr std::size_t long_chain = 12;

// --- Targets of errors

/// m: what overlaps by less does not count, as for the audit.
inline constexpr double least_overlap = 1e-5;
/// Of a target, that what is chosen aims at. With 0.8 islands at rest take 24 substeps for 16 to hold 0.1 mm, and 1.4
/// times as long; what is chosen now is off by less than the rest.
inline constexpr double target_margin = 0.95;
/// Of what the square law leaves to an island in one substep: pyramids then overlap by a third more than that says, and
/// would get one and two in turn.
inline constexpr double one_substep_share = 0.5;
/// Of what the load of a contact or joint explains. By masses alone and times 4, ragdolls that land take 3 times as
/// long to hold 1 mm, and lie no better.
inline constexpr double explained_error = 1.2;
/// Times its weight, that each body of an island that has no past is taken to lie under. From four substeps on, a wall
/// overlaps by 0.2 mm at first where 0.1 is asked for, part of which stays wedged: it takes 40 substeps then for 32.
inline constexpr double first_load = 10;
/// s, without need of as many substeps, after which an island gets fewer: at first, if it has no joints, and later; and
/// the longest, where it needed them again each time. With 0.25 at first balls that roll for two seconds take 1.3
/// to 1.5 times as long as with a fixed number, now 1.1 to 1.2; the others were not tried otherwise.
inline constexpr double first_target_hold = 0.1;
inline constexpr double target_hold = 0.25;
inline constexpr double most_target_hold = 16;
/// Residuals are measured in one step of so many: it takes about the time of a step.
inline constexpr int residual_interval = 8;
/// Of the substep's square times the change of acceleration a second, as of the trapezoidal rule. Pendulums are then
/// off by 0.3 to 1.1 of what was asked for.
inline constexpr double motion_error_share = 1.0 / 12;

// --- At once: the problem and its matrix

/// Of an effective mass's inverse, that contacts and locks give: an overlap of 5 compliance g dt^2 by own weights
/// carried. Doubles hold a top box a million times as heavy as the nine below it at 1e-9; at 1e-6 it sinks by 25 mm,
/// here by 2. At a hundredth bridges fly.
inline constexpr double compliance = 1e-8;
/// Likewise friction: less, and Newton's method finds no way over its edges (at a hundredth what is wedged slips). What
/// is held back by friction alone creeps by this times g dt.
inline constexpr double friction_compliance = 1e-6;
/// Columns have one block of the factor a body, walls 5 to 10.
inline constexpr std::size_t factor_blocks_per_body = 12;
/// Likewise of joints that nothing touches, which are solved at once in each substep whatever they carry. Trees have
/// one, and up to thirteen bodies may all be joined to each other.
inline constexpr std::size_t factor_blocks_per_joined_body = 6;
/// rad: a body whose moments of inertia differ may not turn by more within what is solved for.
inline constexpr double most_tumble = 0.3;

// --- At once: iterations

/// m/s, of what the balance of a body's impulses may lack.
inline constexpr double balance_tolerance = 2e-4;
/// Newton's method takes 0 to 4 iterations at rest. Where contacts close fast, points come and go one by one: with 20,
/// heaps that are shaken take twice as long, to no end.
inline constexpr int most_iterations = 6;
/// It takes more and gets there where a heavy box lands on a chain of light planks (6 to 30 of these), where a belt
/// takes along a column (more than 12), and where all is to be solved at once whatever it takes: a wall of 210 boxes
/// that has just been put up takes 89, and with 30 is swept.
inline constexpr int most_iterations_if_patient = 100;
/// Iterations in which friction's bound follows the load. With more it would go to and fro for long: each halves the
/// difference at best.
inline constexpr int following = 2;
/// Of what would stop all bodies of the island at once and hold their weights: a contact that pushes harder is wedged
/// between others so that nothing tells how hard.
inline constexpr double most_impulse = 10;
/// m/s: slower than this the top of a column may sink. At a hundred times one of 50 boxes sinks by 14 um in 3 s.
inline constexpr double least_sinking = 5e-7;
/// With a million times its weight on it, a box sinks by a tenth of what it did in each; with 4 of them that column
/// falls.
inline constexpr int most_penetration_rounds = 8;

// --- At once: substeps of islands with joints

/// Of a body's inertia: by so much tension may stiffen it before the system is made anew. Without that, boxes of 100
/// times a plank's weight are thrown off a bridge.
inline constexpr double notable_stiffness = 0.1;
/// m/s: points of contacts that part or close faster are left to the next substep's solve.
inline constexpr double resting_speed = 1e-3;
/// Newton steps that close joints in a substep's motion; one, but for one in fifty after impacts. How often each may be
/// shortened to a quarter. Both four times less or more moved nothing.
inline constexpr int most_closing_steps = 20;
inline constexpr int most_shortenings = 4;

}  // namespace atl::solver::tuning
