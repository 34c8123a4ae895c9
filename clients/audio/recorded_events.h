// The events of a recording of hapticd (MCAP, uncompressed; proto/hapticd/v1/recording.proto), for
// offline rendering: read from the front to the back, everything but scenes and events passed over.
// The bytes are not trusted; a file that ends anywhere, as a killed daemon leaves it, gives what is
// whole. Not RT.
#pragma once

#include <cstdint>
#include <functional>
#include <string>
#include <string_view>

#include "hapticd/v1/recording.pb.h"

namespace hapticd::audio {

/// What the reader finds; both are called in the order of the file.
struct RecordingHandlers {
  std::function<void(const v1::SceneRecord&)> scene;
  std::function<void(const v1::EventRecord&)> event;
};

/// Reads the recording in `bytes`; what is wrong with it, empty when nothing is. All that comes
/// before a fault has been handed out.
std::string read_recording(std::string_view bytes, const RecordingHandlers& handlers);

/// The content of a file; throws std::runtime_error with its name and the reason.
[[nodiscard]] std::string file_content(const std::string& path);

}  // namespace hapticd::audio
