// See frame_watch.h.
#include "clients/web/gateway/frame_watch.h"

#include <algorithm>

namespace hapticd::web {
namespace {

// RFC 6455, section 5.2: bits of the first byte, and of the second.
constexpr unsigned kFin = 0x80;
constexpr unsigned kControl = 0x08;
constexpr unsigned kMasked = 0x80;
constexpr unsigned kLength = 0x7f;
/// Values of the length that say how many bytes have it instead.
constexpr unsigned kLengthIn2 = 126;
constexpr unsigned kLengthIn8 = 127;

}  // namespace

void FrameWatch::take(std::string_view bytes, std::int64_t now_ns) {
  while (!bytes.empty()) {
    if (payload_left_ == 0) {
      if (!since_.has_value()) since_ = now_ns;
      take_head_byte(static_cast<unsigned char>(bytes.front()));
      bytes.remove_prefix(1);
      continue;
    }
    const std::size_t taken = std::min<std::uint64_t>(payload_left_, bytes.size());
    bytes.remove_prefix(taken);
    payload_left_ -= taken;
    if (payload_left_ == 0) end_frame();
  }
}

void FrameWatch::take_head_byte(unsigned char byte) {
  head_[head_bytes_++] = byte;
  if (head_bytes_ < 2) return;
  const unsigned shown = head_[1] & kLength;
  const std::size_t wide = shown == kLengthIn8 ? 8 : (shown == kLengthIn2 ? 2 : 0);
  const std::size_t mask = (head_[1] & kMasked) != 0 ? 4 : 0;
  if (head_bytes_ < 2 + wide + mask) return;
  payload_left_ = wide == 0 ? shown : 0;
  for (std::size_t i = 0; i < wide; ++i) payload_left_ = payload_left_ << 8U | head_[2 + i];
  head_bytes_ = 0;
  if (payload_left_ == 0) end_frame();
}

void FrameWatch::end_frame() {
  // Control frames may stand between those of a message.
  if ((head_[0] & kControl) == 0) message_ = (head_[0] & kFin) == 0;
  if (!message_) since_.reset();
}

}  // namespace hapticd::web
