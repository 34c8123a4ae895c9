// The files of the keys of a daemon: view.key and control.key of its sessions, stop.key of its Stop
// road, 32 bytes each, readable by their owner alone. PROTOCOL.md, sections 12 and 17. Not RT.
#pragma once

#include <filesystem>

#include "proto/noise/handshake.h"

namespace hapticd::noise {

inline constexpr const char* kViewKeyName = "view.key";
inline constexpr const char* kControlKeyName = "control.key";
inline constexpr const char* kStopKeyName = "stop.key";

/// The keys of a daemon's sessions.
struct KeyPair {
  Key view{};
  Key control{};
};

/// The key in `file`. Throws std::runtime_error with the file and the remedy: it cannot be read, is
/// no file of 32 bytes, or users other than its owner may access it.
[[nodiscard]] Key read_key_file(const std::filesystem::path& file);

/// Both keys of sessions in `folder`. Throws std::runtime_error as read_key_file() does, and when
/// the keys are equal: whoever may look could then control.
[[nodiscard]] KeyPair read_key_folder(const std::filesystem::path& folder);

/// Makes `folder` if need be, and three random keys in it; where the two of sessions are there
/// already, and no stop.key, that one alone. Throws std::runtime_error with the reason and the
/// remedy; a key that is there is never overwritten.
void make_key_folder(const std::filesystem::path& folder);

}  // namespace hapticd::noise
