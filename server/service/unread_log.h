// The log on stdout, which waits for nobody: where it is a pipe that nobody reads, or a terminal
// that is stopped (Ctrl-S), lines are left out and counted, and the threads that log go on. Not RT.
#pragma once

namespace hapticd {

/// From here on a line that stdout does not take at once is left out; how many were is said as soon
/// as it takes one again. Lines longer than 3000 bytes are cut there.
void log_without_waiting();

}  // namespace hapticd
