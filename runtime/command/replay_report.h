#pragma once

#include <atoll/recording.h>

#include <iosfwd>
#include <string>
#include <vector>

#include "replay.h"

namespace atl::command {

/// `body 17: pose, contacts`.
std::string body_words(const ReplayedBody& body);
/// A line each, the first few of them, and how many more there are.
void write_bodies(std::ostream& out, const std::vector<ReplayedBody>& bodies);

/// `step 41, body 17: pose, contacts`.
std::string first_words(const ReplayDivergence& divergence);

/// Whose recording it is, and how the replay went; then the bodies that differ.
void write_replay_text(std::ostream& out, const ReplayFileOptions& options, const ReplayResult& result);
/// The same as one object.
void write_replay_json(std::ostream& out, const ReplayFileOptions& options, const ReplayResult& result);

}  // namespace atl::command
