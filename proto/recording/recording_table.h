// A recording as a table, one row per tick or per event: CSV, or NPY (numpy.lib.format, version
// 2.0, a structured array). Columns have their unit at the end of their name; whole numbers stay
// whole, real ones keep every bit (17 digits in CSV). Not RT.
#pragma once

#include <cstdint>
#include <string>

namespace hapticd {

enum class TableRows : std::uint8_t { kTicks, kEvents };
enum class TableForm : std::uint8_t { kCsv, kNpy };

/// Writes `rows` of the recording at `path` to `file`, which is replaced; returns how many there
/// are. Throws RecordingError when there are none, when one is damaged, and when `file` cannot be
/// written. Reads the recording twice: how many tools the columns need is known at its end.
std::uint64_t write_table(const std::string& path, TableRows rows, TableForm form,
                          const std::string& file);

}  // namespace hapticd
