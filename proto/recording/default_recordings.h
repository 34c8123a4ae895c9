// Where recordings are that nobody gave a folder. Not RT.
#pragma once

#include <filesystem>
#include <string>

namespace hapticd {

/// Where a hapticd of this user writes its recordings: hapticd/recordings in $XDG_STATE_HOME, or in
/// ~/.local/state. One that runs as a service has another folder.
[[nodiscard]] std::filesystem::path default_recordings();

/// The file `name`; where there is none, and `name` has no folder, that of default_recordings(), as
/// `hapticctl record list` names it. `name` itself where neither is there.
[[nodiscard]] std::string find_recording(const std::string& name);

}  // namespace hapticd
