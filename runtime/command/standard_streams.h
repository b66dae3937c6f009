#pragma once

namespace atl::command {

/// Makes sure of two things before anything is opened or written. A standard stream that the process was started
/// without is not mistaken for the next file that is opened. And a pipe whose reader has gone makes a write fail,
/// rather than end the process in the middle of its files.
void prepare_standard_streams();

/// Thrown where nobody reads the standard output any more, which is no failure: see end_by_closed_pipe().
struct ReaderGone {};

/// Ends each output of results. Throws Failure with Status::Usage if not all of it could be written, and ReaderGone if
/// that is because its reader has gone. If the process was started with SIGPIPE ignored, that is reported as a failure,
/// too.
void finish_output();

/// Ends the process without a word, by SIGPIPE, as other programs in pipes end: shells tell it as status 141.
int end_by_closed_pipe();

}  // namespace atl::command
