// Tables for other programs: of States that a session collected, and of recordings. One row per
// tick or event, one column per number, its unit at the end of its name; whole numbers stay whole,
// real ones keep every bit (17 digits).
#pragma once

#include <hapticd/v1/state.pb.h>

#include <cstdint>
#include <string>
#include <vector>

#pragma GCC visibility push(default)
namespace hapticd::client {
inline namespace abi_0 {

/// Writes the States as CSV, a row per State: tick, t_ns, loop_state, cause, and for tool k of
/// each, toolk_...: id, poses wh and wg, force and torque in W about H, minimum gap. `file` is
/// replaced. Where a State has fewer tools than the first one, the fields are empty. Throws
/// std::runtime_error when there is no State, or the file cannot be written.
void write_states(const std::vector<v1::State>& states, const std::string& file);

enum class RecordedRows : std::uint8_t { kTicks, kEvents };

/// Writes the ticks or the events of the recording `recording`, a file of this machine, to `file`:
/// as NPY where that name ends in .npy, else as CSV: the table that `hapticctl export` writes.
/// Returns the number of rows. Throws std::runtime_error when there are none, when the
/// recording is damaged, or when `file` cannot be written.
std::uint64_t write_recording(const std::string& recording, RecordedRows rows,
                              const std::string& file);

}  // namespace abi_0
}  // namespace hapticd::client
#pragma GCC visibility pop
