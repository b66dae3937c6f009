#pragma once

#include <cstddef>

/// Every tuned number of the solver: its unit, what it trades, and what set it. "Suite" is `atoll verify --stability`;
/// most were also moved by four both ways with it and with ten built-in scenes, and where nothing moved that is said.
/// Numbers that a method or a paper gives, and grains of parallel loops, stay where they are used.
namespace atl::solver::tuning {

// --- Soft contacts and joints in sweeps

/// Frequency of contacts, as part of the substep rate. Twice of it is 4 times as stiff, but a pyramid of 22 layers
/// drifts by 55 mm instead of 10. With half of it a wide wall sinks by 0.58 m instead of 42 mm.
inline constexpr double contact_hertz_share = 0.125;
/// The highest frequency of contacts that may be asked for, as part of the substep rate. From 1 on, stacks of soft
/// contacts drift off.
inline constexpr double contact_hertz_limit = 0.25;
/// Highest frequency of swept joints, as part of the substep rate. If a sweep removes a small part e of an error, n
/// sweeps with softness push and r relax. Such a joint rings up from x^2 = 1 + r / n on, with x its angular frequency
/// by the substep rate, or from 0.286 on with one sweep and two (a net of balls from 0.4). Measured: of 300 random
/// mechanisms 9 gain energy with 0.3, and 4 with 0.275 or 0.25; ragdolls are open by 0.38, 0.41 and 0.54 mm.
inline constexpr double joint_hertz_limit = 0.28;
/// Relaxing sweeps over joints for each one asked for. At 0.275, with one, 19 of these mechanisms gain energy; with
/// three as many as with two.
inline constexpr int joint_relaxations = 2;
/// Sweeps over joints ahead of a substep's last are over-relaxed in what holds points (D. M. Young, "Iterative methods
/// for solving partial difference equations of elliptic type", 1954): by n / (n + this) where n more follow. That takes
/// more of the slowest errors at the price of fast ones, which later sweeps smooth. At 32 sweeps a rigid chain of 20,
/// with 100 times the mass at its end, is open by 0.76 mm without, 0.31 with this, 0.18 with 8 and 0.10 with 3; a net
/// by 0.117, 0.055, 0.038 and 0.028. But of 4800 runs of random mechanisms on rigid joints 14 gain energy without, 15
/// with this and 23 with 8. With locked rows over-relaxed too, 28 of 300 do at 16 sweeps and 3.
inline constexpr float relaxing_sweeps = 20;
/// Smallest part of a row's response J M^-1 J^T that must be left while its joint holds. A row with less would act by
/// single precision's rounding, and stays as it is; or is left out, where it is motion locks that leave so little.
inline constexpr double min_response_share = 1e-5;
/// The same of what locks leave, in sweeps: a row that pushes with the mass of so little throws what it isn't quite
/// free of. Of 2000 random assemblies with locks, 8 sweeps and a step's defaults, 3 gain energy at 1e-5, 4 at 1e-4, 1
/// at 1e-3 and none here.
inline constexpr double min_swept_response_share = 3e-3;
/// Part of its distance from rest by which a swept spring or servo moves a body at most in a substep, but for a joint
/// alone with one; a stiffer one is damped until it does. Others answer a sweep later: springs that close all of it at
/// once ring up with them. Of 1500 random mechanisms with springs, ranges and pins, at one sweep, 31 gain energy
/// without, 14 at 0.6 and 4 here. By default a spring of 20 Hz closes as much.
inline constexpr double max_swept_closing = 0.3;
/// The same of all joints around a body together, that may pull it one way. Sixteen springs that close a quarter each
/// lose a ball; up to six are bound as one by itself.
inline constexpr double max_swept_closing_together = 2;
/// m or rad by which a locked coordinate is brought back in a substep at most. Without, hinges whose axes are put apart
/// close at 248 rad/s; with an eighth of it a servo's arm gets nine tenths of the torque. Also the distance from the
/// ends of its range from which on a free coordinate need not be ready to act.
inline constexpr double max_closing = 0.1;

/// Penetration of soft contacts under their load above which they stiffen, in parts of the smaller body's half
/// thickness. `pile` overlaps by 10.6 mm in the mean without stiffening, by 4.6 mm with 1% and by 3.3 mm with half a
/// percent, in the same time. With stiffening a wall of 50 boxes sinks by 8 cm instead of 17, but drifts by 25 cm
/// instead of 5, which it doesn't with 2%.
inline constexpr double stiffening_penetration = 0.01;
/// Largest factor of stiffening. With 2, 4 and 16 `pile` overlaps by 6.3, 5.0 and 4.5 mm in the mean, with 8 by 4.6.
inline constexpr float max_stiffening = 8;
/// rad a step: the contacts of a body that turns by more are placed as they will be half way through the step.
inline constexpr double min_turn = 1e-5;
/// rad a step, up to which a body is assumed to turn on as it does. The part of the half turn by which contacts are
/// moved falls with the fourth power of the turn. With 1 a top of 50 rad/s, whose nutation no step of 1/60 s resolves,
/// falls over (an error of 1.2 instead of 0.27, relative to its tilt); with 0.25 or 0.5 rolling bodies are the same.
inline constexpr double known_turn = 0.25;
/// Rounds in which contacts that are solved at once follow the turns that solutions tell, and the part of gravity that
/// a turn must be missed by for another one, as a change of the rim's speed in the step. A coin (10 cm, 11.5 rad/s)
/// that rolls in a circle for 3 s at 1/60 s comes to lean by .55 rad too much with no round, .02 with one, 1e-4 with
/// two. At 25 times this part it leans by .035 too much at 1/240 s.
inline constexpr int turn_rounds = 3;
inline constexpr double foreseen_part = 1e-4;
/// rad a step, times the root of the largest moment of inertia over the least. A body that turns by more is in another
/// orientation than the one its contacts know; see PassiveEnergy. Of 120 rods that fall on the ground and turn by 1.1
/// rad a step none gains a thousandth of its energy, of 120 that turn by 1.6 four do.
inline constexpr double blind_turn = 1;
/// Lower bound of the squared sine of the angle between a round body's axis and a normal. A body that lies flat is
/// touched at no single point of its rim, and the point would move along the rim as far as it likes.
inline constexpr double min_lean = 0.01;
/// (m/s)^2. The push speed grows with the root of gravity times size (the contact's distance from the centre of mass)
/// above this value. Boxes of a metre come to half of it on Earth. Without, boxes of a kilometre overlap by a tenth.
inline constexpr double reference_gravity = 9.81;
/// m/s: a contact that closes faster gets more rounds over its points, since otherwise a body that lands flat is left
/// turning. A box of 1 m dropped flat from 3 m slides by 0.05 mm instead of 15, from 10 m by 4 mm instead of 150. At an
/// eighth, bodies that merely move get the rounds too: a piston's load is thrown at 15 m/s.
inline constexpr float landing_speed = 0.5f;
/// m/s, closing or parting, from which on all points of a contact are first changed at once. With 0.05 and 0.25 a box
/// dropped flat from 2.5 m ends 7 um aside, without it 3.7 mm. At 0.05 a column that a belt takes along leans. Islands
/// without joints in which a contact closes or parts faster are on the move, see max_iterations_if_fast.
inline constexpr float spread_speed = 0.25f;
/// Rounds over the points of each contact that lands. With one, hopper overlaps by twice as much; with 28 a coin's
/// landing is farther off.
inline constexpr int landing_rounds = 7;
/// Slowest impact that bounces by default, in parts of the speed that gravity gives in a substep. With 1, bodies at
/// rest rattle. A ball of restitution 0.8 that falls from 1 m comes to rest after 3.95 s with 2, after 3.3 s with 25,
/// and after 4.06 s by its closed form.
inline constexpr double min_bounce = 2;

/// Rounds of passing an impact on from body to body within a substep; the rest waits for the next. A row of 40 balls
/// takes 40. With 8, boxes that fall in a heap take 5% less time.
inline constexpr int max_impact_rounds = 64;
/// Sweeps over simultaneous impacts in a round, and the part of their fastest speed that the last sweep may change.
/// With these, a rack of 15 balls parts symmetrically to 5e-11 m/s of 8; with 1000 and 1e-13 it does to 1e-13. 1000
/// boxes of restitution 0.1 that fall in a heap take 2.5 ms a step, 2.9 with 50 sweeps, and 5.8 and more with 1000.
inline constexpr int max_impact_sweeps = 20;
inline constexpr double impact_tolerance = 1e-10;
/// Bodies of a system of joints that a round of impacts hits at most; the others wait for the next. What they answer
/// takes six solves each, and memory by their square: 300 links that fall flat at once take 140 ms a step so, and 18 ms
/// if each is hit by itself.
inline constexpr std::size_t max_hit = 32;

/// Newton's steps to friction's ellipse, to 1e-12. With half axes of up to a million to one, a million random slips
/// took 15 at most, and half of them 3.
inline constexpr int ellipse_rounds = 16;
/// Sweeps over a group's joints in a substep in which some coordinate bounces at the end of its range.
inline constexpr int joint_bounce_sweeps = 16;

/// rad/s: the tumbling of bodies that spin slower is neglected (the square is an angular acceleration), so that a pile
/// at rest need not pay for it. It is no turn in a substep, or finer steps would be worse.
inline constexpr double min_spin = 0.02;

// --- Joints

/// Part by which the tension that geometric stiffness is made of follows a joint's force in a substep, or in a step if
/// joints are swept. It is smoothed because the forces of light links are noisy. A chain of 100 links with 100,000
/// times the mass at its end opens by 24 mm with 1, and by a nanometre with 0.2; one of 1,000,000 times breaks with
/// 0.8.
inline constexpr double tension_smoothing = 0.2;
/// m/s or rad/s: fastest return of a coordinate into its range. The same as contacts' default push speed.
inline constexpr double closing_speed = 3;
/// rad: the bend of joints whose arms swing by more in a substep is not foreseen, but corrected after the substep. Ten
/// rods that whip at 1/3 rad keep their energy to 60% so, and to 800% without a limit.
inline constexpr double max_bend = 0.1;
/// rad/s: the bend of arms that turn slower is neglected. With 0.1 small swings are no longer of second order.
inline constexpr double min_bend_spin = 1e-3;
/// Part of its rate that a damper takes from its two bodies alone in a substep, above which its mass is that of all
/// joined bodies. Without, the wrist of a Shadow hand, whose bodies are light and carry the fingers, is off by 9e-4 rad
/// after a second at 1/240, with it by 7e-5. If servos are treated alike, a humanoid takes 1.4 times as long, and is
/// off by as much.
inline constexpr double notable_decay = 0.3;
/// m or rad: gaps larger than this after a Newton step get another one. At a hundredth the chatter of loads on a bridge
/// grows by 4%, at a hundred times energy does.
inline constexpr double open_gap = 1e-4;
/// m or rad: gaps larger than this at the end of a step, left by displacements in single precision, are closed in
/// double. With 1e-7 ragdolls of joints that are solved at once ended steps 1e-8 m apart.
inline constexpr double settled_gap = 1e-9;
/// m or rad: the farthest that closing joints moves a body. Larger moves come from rows that are near singular.
inline constexpr double far_at_rest = 0.3;
/// Rounds of finding which limits, motors and springs hold in one substep. With 3, ragdolls overlap twice as much; with
/// 48 nothing moved. Newton's method finds what hasn't settled by then.
inline constexpr int mode_rounds = 12;
/// Compliance of locks, in parts of an effective mass's inverse, for joints in loops that nothing touches: the rows of
/// a loop are redundant. Eight windows in a row, whose rods come to lie in a line twice a turn, are off by 0.03% of
/// their energy with it, and by 6.6% with the compliance of contacts.
inline constexpr double compliance_of_loops = 1e-6;
/// Of the inner radius of the smaller body: an overlap that only bodies have that were put into each other; see
/// PassiveEnergy. Without it 300 cubes of 1 m in one place leave at 94 m/s, and with any from 0.1 to 0.5 at 1e-5 m/s.
/// With 0.05 heaps of planar boxes are touched, and come to rest later.
inline constexpr float deep_overlap = 0.5f;

/// Compliance of locks in trees: just enough for two redundant locks to share their load.
inline constexpr double compliance_of_trees = 1e-10;

/// Part of the kinetic energy that a solve of joints may add, beyond the work of springs and motors; if it adds more,
/// it is solved again by a method that can't add any. Without this, 2 of 400 random mechanisms gain a twentieth of
/// their energy, with it none; the scenes of the suites for stability and physics exceed it 10 times in all.
inline constexpr double energy_tolerance = 1e-3;
/// The same of what an island with swept joints may add in a step. Of 3000 random mechanisms 2 grow by a twentieth in
/// five seconds with ten times as much, none with this or a tenth.
inline constexpr double held_tolerance = 1e-4;
/// Rounds in which carried impulses are scaled after an impact, each contact by its own share. With one the worst of
/// 400 heaps of unequal masses gains 5% in a step, with two and more 1%, without any 44%.
inline constexpr int fitting_rounds = 2;
/// A body is struck where contacts change its velocity by more than gravity does in a step, of at least so many
/// substeps. With 2 a wall in two substeps errs more than in one; with 4 one of 200 columns is pressed through hills.
inline constexpr double struck_substeps = 3;
/// m/s: closing gaps gives joined bodies no more kinetic energy than their mass has at this speed. Of 6000 random
/// mechanisms one explodes without it, none with it.
inline constexpr double max_closing_speed = 3;
/// Energy error that is tolerated in islands whose joints touch something, in parts of the energy that springs and
/// servos exchange with motion in a step. A box of 1 kg that slides on a spring of 20 Hz with a rotor has a tenth of
/// its energy left after nine seconds with 0, eight tenths with 0.01, and all with this.
inline constexpr double exchange_tolerance = 0.1;
/// Largest part by which the energy of jointed bodies is corrected in a step: see Conservation. With 0.05 three rods
/// that whip lose all of theirs in 100 s at the default step, with 0.5 none.
inline constexpr double max_energy_restored = 0.5;
/// Parting speed of joints as a step begins, in parts of the island's fastest speed, above which something must have
/// struck the island. Closed gaps leave a tenth of it.
inline constexpr double max_parting = 1e-3;
/// rad: energy isn't corrected if an arm swings by more in a substep. With 0.1 ten rods that are let go level lose 43%
/// of theirs in 100 s at the default step.
inline constexpr double max_resolved_swing = 0.3;
/// J/kg: a smaller energy is rounding.
inline constexpr double min_energy = 1e-12;
/// m/s or rad/s, and as part of the rate: a motor farther from its speed as a step begins has been at its limit of
/// force. The number allows for rates in single precision within a step. Not tried otherwise.
inline constexpr double motor_behind = 1e-5;

/// Cosine of half the swing below which a twist fades: at 120 degrees. Not tried otherwise.
inline constexpr double fading_twist = 0.5;
/// Cosine of half the turn below which a coordinate of turn_about() fades: at 151 degrees, where it is 1.94 of its 2.
/// Sine between two hinges below which angles about them fade: 14 degrees before they are parallel, where a row is
/// 4 times as long. Not tried otherwise.
inline constexpr double fading_turn = 0.25;

// --- Which islands are solved how

/// The default error budget: penetration of soft contacts under their load, in parts of the smaller body's half
/// thickness, above which they count as overloaded. A column of boxes starts to buckle from about 15 boxes on, at 1.6%
/// (by Euler's load; a longer one takes a while). At four times a wide wall sinks by 0.7 m; at a quarter a wall of 50
/// boxes takes 2.3 times as long, and sinks by 10 mm instead of 167.
inline constexpr double overload_penetration = 0.015;
/// The same for islands that are mostly columns, which cost little to solve at once. It is reached by five boxes. With
/// 0.5% (six boxes) stacks of five overlap by 2.2 mm, which five of the suite's criteria don't allow; with 0.4% a body
/// that lands on a stack of three is taken for a load. At four times columns of ten and arches fall. At a quarter it
/// would take in stacks of two, which in a crowd then take three times as many instructions a step.
inline constexpr double column_penetration = 0.0043;
/// Contacts a body up to which an island counts as columns or arches. At a quarter these are no longer recognised; at
/// four times the contents of a piston are taken for some.
inline constexpr double contacts_of_columns = 1.5;
/// Penetration that counts as deep, in parts of the contact's arm. A quarter of it makes hopper 2.4 times as dear, four
/// times moves nothing; without any a heavy box sinks through four small ones.
inline constexpr double deep_penetration = 0.12;
/// Mass ratio of a body to a jointed one under it from which on it counts as deep in it. It exceeds the ratios among
/// the limbs of a body. With 10, a hundred ragdolls take six times as long.
inline constexpr double deep_ratio = 64;
/// Substeps of a step for which the softness of contacts is taken when their load is checked. With more substeps
/// contacts are stiffer, but a check by the actual number would leave a wall to eight substeps, and it would sink by
/// 165 mm. A wall asked for four gets sixteen, and sinks by 41. More substeps don't settle columns either: with 16 a
/// tower of 50 boxes that gives by only 0.3% falls.
inline constexpr double assumed_substeps = 4;
/// Lower bound of a body's extent along the normal, in parts of the contact's arm, for bodies touched at a rim. At four
/// times card houses sag, at a quarter nothing moved.
inline constexpr double min_thickness = 0.1;
/// Smallest cosine between a normal and up with which a contact counts as support when loads are estimated. A quarter
/// of it moved nothing.
inline constexpr double min_slope = 0.3;
/// Steps between estimates of the loads in an island, while its bodies stay the same. With 1 pyramids take 5% longer,
/// and with 4 they take 1%.
inline constexpr int load_interval = 4;
/// s, for which an island is swept after it could not be solved at once. 4000 boxes on plates that shake try in vain
/// 616 times in 200 steps with 0.5, 247 times with 2, and take three quarters of the time.
inline constexpr float failed_time = 2;
/// Part of an island's bodies that must sag under their load for it to get finer substeps. These are for structures
/// built to stand. They don't pay for a few small stones under large ones, and they stir a heap that has come to rest
/// on soft contacts, since they stiffen these. With a quarter of it, walls of 50 boxes get them, at 2.2 times the time.
inline constexpr double part_of_island = 0.25;
/// s, the longest substep of an island that sags: a wall of 100 layers sinks by 165 mm with twice of it, and by 41 with
/// it; with a quarter squeezed bodies get out.
inline constexpr double refined_substep = 1.0 / 960;
/// Factor of substeps for a body that leans on one thing and lands on another. Tilts of a block that rocks are off by
/// 12% with 1, by 3.4 with 4, by 2.5 with 8 and by 1.5 with 16; in 6% more time with 8, in 12 with 16.
inline constexpr int landing_refinement = 8;
/// Largest number of bodies of an island that is solved at once: larger ones take longer than a step may.
inline constexpr std::size_t max_bodies = 400;
/// Largest mass ratio of a body to a jointed one that it lies on, for joints and contacts to be solved in turns. Boxes
/// of 10 times a plank's weight bounce off a bridge at 2.3 m/s, of 30 times at 4, where 0.9 is right.
inline constexpr double light_ratio = 10;
/// Largest part of an error that a sweep over two joints may leave, for a body that both hold. It is the largest
/// eigenvalue of J1 J2^T J2 J1^T, with rows scaled by J M^-1 J^T of each joint. Two heavy wheels on a light bar ring
/// up, from 34 J to 230 kJ in 5 s, at 0.78, and don't at 0.77 and below. Chains of hinged capsules, which don't ring up
/// either, come to 0.74; solving them at once as well takes 3.4 times as long.
inline constexpr double max_error_left = 0.76;
/// Largest number of joints on the longest path through swept joints; longer chains are solved at once. 3 or 48 moved
/// nothing.
inline constexpr std::size_t long_chain = 12;

// --- Targets of errors

/// m: a smaller overlap does not count, as in the audit.
inline constexpr double min_overlap = 1e-5;
/// Part of a target that the choice of substeps aims at. With 0.8 islands at rest take 24 substeps instead of 16 to
/// hold 0.1 mm, and 1.4 times as long; the error of the choice is smaller than the margin left.
inline constexpr double target_margin = 0.95;
/// Part of the error by the square law up to which an island gets a single substep. Pyramids then overlap by a third
/// more than the law says, and would alternate between one and two.
inline constexpr double one_substep_share = 0.5;
/// Factor of the error that the load of a contact or joint explains. By masses alone and times 4, ragdolls that land
/// take 3 times as long to hold 1 mm, and lie no better.
inline constexpr double explained_error = 1.2;
/// Assumed load on each body of an island without history, in multiples of its weight. If it starts from four substeps,
/// a wall overlaps by 0.2 mm at first where 0.1 is asked for. Part of that stays wedged: it then takes 40 substeps
/// instead of 32.
inline constexpr double first_load = 10;
/// s, after which an island that needs fewer substeps gets fewer: the first time, for islands without joints; later;
/// and the longest, for one that needed them again each time. With 0.25 the first time, balls that roll for two seconds
/// take 1.3 to 1.5 times as long as with a fixed number, now 1.1 to 1.2; the others were not tried otherwise.
inline constexpr double first_target_hold = 0.1;
inline constexpr double target_hold = 0.25;
inline constexpr double max_target_hold = 16;
/// Steps from one measurement of residuals to the next: one takes about the time of a step.
inline constexpr int residual_interval = 8;
/// Factor of the motion error: times the substep's square and the acceleration's rate of change, as for the trapezoidal
/// rule. Pendulums are then off by 0.3 to 1.1 of what was asked for.
inline constexpr double motion_error_share = 1.0 / 12;

// --- At once: the problem and its matrix

/// Compliance of contacts and locks, in parts of an effective mass's inverse. The overlap under a load is 5 compliance
/// g dt^2 for each own weight carried. In doubles, a top box a million times as heavy as the nine below it stands with
/// 1e-9. With 1e-6 it sinks by 25 mm, with this by 2. At a hundredth bridges fly.
inline constexpr double compliance = 1e-8;
/// The same for friction. With less, Newton's method finds no way over the kinks of friction (at a hundredth wedged
/// bodies slip). Bodies held by friction alone creep by this times g dt.
inline constexpr double friction_compliance = 1e-6;
/// Largest number of blocks of the factor a body. Columns have one, walls 5 to 10.
inline constexpr std::size_t factor_blocks_per_body = 12;
/// The same for joints that nothing touches, which are solved at once in each substep whatever they carry. Trees have
/// one, and up to thirteen bodies may all be joined to each other.
inline constexpr std::size_t factor_blocks_per_joined_body = 6;
/// rad: a body whose moments of inertia differ may not turn by more in the time that is solved for.
inline constexpr double max_tumble = 0.3;

// --- At once: iterations

/// m/s: how far the velocity of a body may be from that by the impulses on it.
inline constexpr double balance_tolerance = 2e-4;
/// Newton's method takes 0 to 4 iterations at rest, from the impulses of the last step. Where a belt drags a column
/// along it takes 7, and some more as the column no longer slips; with 8 that is swept. Where it takes many, points
/// come and go one by one, and heaps that are shaken pay for it to no end: 4000 boxes on plates that shake take 1.07
/// times as long as by sweeps alone, 1.3 with 20 and 3.3 with 100.
inline constexpr int max_iterations = 10;
/// The limit where contacts close or part faster than spread_speed: a box a thousand times as heavy as those of the
/// column that it lands on takes no more. With 6, the boxes that are shaken take 1.13 times as long.
inline constexpr int max_iterations_if_fast = 1;
/// The limit for islands that have just come together, with joints, and of all that must be solved at once whatever it
/// takes: a belt that takes along a column (17), a heavy box that lands on a chain of light planks (6 to 30), a wall of
/// 210 boxes that has just been put up (89; with 30 it is swept).
inline constexpr int max_iterations_if_patient = 100;
/// Iterations in which friction's bound follows the load. With more it would go to and fro for long: each halves the
/// difference at best.
inline constexpr int following = 2;
/// Rounds in which bounds follow once more the loads of a solution, until no contact's friction is off what its own
/// load bounds it to by more than such a part of the largest bound. Without, two boxes that slide stop dead by thirty
/// times their friction, and of 1296 stacks that slide 562 are off by 2% or more; so, 73 are, most of them swept.
inline constexpr int friction_rounds = 8;
inline constexpr double friction_tolerance = 0.02;
/// Largest impulse of a contact, in multiples of the impulse that would stop all bodies of the island and hold their
/// weights. One that pushes harder is wedged between others, so that its force is undetermined.
inline constexpr double max_impulse = 10;
/// m/s: slowest sinking of a column's top that is corrected. At a hundred times one of 50 boxes sinks by 14 um in 3 s.
inline constexpr double min_sinking = 5e-7;
/// Rounds of correcting the sinking. With a million times its weight on it, a box sinks in each round by a tenth of
/// what it did in the one before; with 4 rounds that column falls.
inline constexpr int max_penetration_rounds = 8;

// --- At once: substeps of islands with joints

/// m/s: contact points that part or close faster are left to the next substep's solve.
inline constexpr double resting_speed = 1e-3;
/// Newton steps that close joints in a substep's motion, and how often each may be shortened to a quarter. One step is
/// enough but after impacts, and where chains are taut: with 5 a bridge that just spans its posts opens by 243 mm.
inline constexpr int max_closing_steps = 20;
inline constexpr int max_shortenings = 4;

}  // namespace atl::solver::tuning
