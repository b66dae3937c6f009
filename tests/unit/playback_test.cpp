// Recordings forwards and backwards: every step is the state that it was, whatever was looked at before.

#include <atoll/atoll.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cstdint>
#include <utility>
#include <vector>

#include "recorded_yard.h"
#include "support/expect_error.h"
#include "support/random.h"
#include "support/temporary_file.h"

namespace atl::test {
namespace {

/// A recording of all changes there are, some steps apart, and what the world came to after each step.
struct Film {
  TemporaryFile file{".recording"};
  std::vector<std::uint64_t> hashes;

  Film() {
    Yard yard({.settings = {.sleeping = true}});
    yard.world.record(file.path());
    hashes.push_back(yard.world.state_hash());
    const auto step = [&] {
      yard.world.step(dt);
      hashes.push_back(yard.world.state_hash());
    };
    for (const Change& change : changes()) {
      // These step, or take away what others ask for.
      if (change.kind == RecordKind::State || change.kind == kind_of<calls::Release>() ||
          change.kind == kind_of<calls::RemoveBody>() || change.kind == kind_of<calls::RemoveJoint>()) {
        continue;
      }
      for (int i = 0; i < 4; ++i) step();
      change.make(yard);
    }
    step();
    Snapshot before;
    yard.world.save(before);
    yard.world.remove_body(yard.ids[4]);
    yard.world.add_body({.shape = wedge(0.4), .position = {0, 0, 6}});
    for (int i = 0; i < 9; ++i) step();
    yard.world.restore(before);
    for (int i = 0; i < 9; ++i) step();
    yard.world.remove_joint(yard.hinge);
    yard.world.remove_body(yard.ids[1]);
    for (int i = 0; i < 9; ++i) step();
    yard.world.step(dt, [](Forces& forces) {
      for (const BodyId id : forces.world().bodies()) forces.add(id, {0, 3, 40});
    });
    hashes.push_back(yard.world.state_hash());
    yard.world.stop_recording();
  }
};

TEST(Playback, EveryStepIsTheOneThatWasRecorded) {
  const Film film;
  const auto steps = static_cast<std::int64_t>(film.hashes.size()) - 1;
  for (const int threads : {1, 2}) {
    // Room for all, for a few, and for none.
    for (const std::size_t room : {std::size_t{1} << 30, std::size_t{60'000}, std::size_t{0}}) {
      Playback playback(film.file.path(), {.threads = threads, .key_frame_bytes = room});
      EXPECT_EQ(playback.steps(), steps);
      EXPECT_EQ(playback.step(), 0);
      Random random(5);
      const auto expect_there = [&](std::int64_t step) {
        ASSERT_EQ(playback.step(), step);
        ASSERT_EQ(playback.world().state_hash(), film.hashes[static_cast<std::size_t>(step)])
            << step << " with " << room << " bytes";
        EXPECT_FALSE(playback.divergence().has_value());
      };
      expect_there(0);
      for (std::int64_t step = 1; step <= steps; ++step) {
        ASSERT_TRUE(playback.advance());
        expect_there(step);
      }
      EXPECT_FALSE(playback.advance());
      for (std::int64_t step = steps; step-- > 0;) {
        playback.seek(step);
        expect_there(step);
      }
      for (int i = 0; i < 100; ++i) {
        const auto step = static_cast<std::int64_t>(random.real(0, static_cast<double>(steps) + 0.99));
        playback.seek(step);
        expect_there(step);
      }
    }
  }
}

TEST(Playback, ReportsTheStepItMade) {
  const Film film;
  Playback playback(film.file.path());
  playback.seek(6);
  EXPECT_GT(playback.report().counts.contacts, 0);
  EXPECT_EQ(playback.dt(), dt);
}

// Leaving work out changes no bit while numbers are finite. The recording keeps the choice for numbers that are not.
TEST(Playback, LeavesOutWhatWasLeftOut) {
  const TemporaryFile file(".recording");
  Yard yard({.settings = {.sleeping = false}});
  yard.world.record(file.path());
  for (const bool everything : {false, true, false}) {
    Settings settings = yard.world.settings();
    settings.run_everything = everything;
    yard.world.set_settings(settings);
    yard.world.step(dt);
  }
  yard.world.stop_recording();
  Playback playback(file.path());
  for (const std::int64_t step : {1, 2, 3, 2, 1}) {
    playback.seek(step - 1);
    ASSERT_TRUE(playback.advance());
    EXPECT_EQ(playback.world().settings().run_everything, step == 2);
    EXPECT_EQ(playback.report().feature(Feature::ContactProblem).run, step == 2);
  }
}

TEST(Playback, RefusesStepsThatThereAreNot) {
  const Film film;
  Playback playback(film.file.path());
  expect_error([&] { playback.seek(-1); }, {"Playback::seek: step is -1; expected one in [0, "});
  expect_error([&] { playback.seek(playback.steps() + 1); }, {"the steps of the recording"});
  expect_error([] { Playback("/nowhere"); }, {"replay: /nowhere: "});
}

}  // namespace
}  // namespace atl::test
