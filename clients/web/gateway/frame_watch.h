// Whether a peer of a WebSocket owes the rest of something: follows the frames of RFC 6455, section
// 5.2, byte by byte, and judges nothing. What is no frame is for whoever reads them to refuse.
// Pure. Not RT.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string_view>

namespace hapticd::web {

class FrameWatch {
 public:
  /// What came next, at `now_ns` of a clock that never goes back.
  void take(std::string_view bytes, std::int64_t now_ns);
  /// When the first byte came of a frame that is not whole, or of a message whose last frame is
  /// not; nothing: the peer owes nothing.
  [[nodiscard]] std::optional<std::int64_t> unfinished_since_ns() const noexcept { return since_; }

 private:
  void take_head_byte(unsigned char byte);
  void end_frame();

  std::array<unsigned char, 14> head_{};  ///< the longest there is
  std::size_t head_bytes_ = 0;            ///< that came of it
  std::uint64_t payload_left_ = 0;        ///< of this frame
  bool message_ = false;                  ///< further frames of it are to come
  std::optional<std::int64_t> since_;
};

}  // namespace hapticd::web
