// Where recordings are that nobody gave a folder. Not RT.
#pragma once

#include <filesystem>
#include <string>

namespace hapticd {

/// Where a hapticd of this user writes its recordings: hapticd/recordings in $XDG_STATE_HOME, or in
/// ~/.local/state.
[[nodiscard]] std::filesystem::path default_recordings();
/// Where one that runs as a service does, unless its unit says otherwise.
[[nodiscard]] std::filesystem::path service_recordings();

/// The file `name`; where there is none, and `name` has no folder, that of default_recordings() or
/// service_recordings(), as `hapticctl record list` names it; the same with .mcap behind. `name`
/// itself where none of them is there, or may not be looked for.
[[nodiscard]] std::string find_recording(const std::string& name);

}  // namespace hapticd
