// See channel.h.
#include "proto/wire/channel.h"

#include <google/protobuf/stubs/logging.h>

#include <algorithm>
#include <array>
#include <utility>

namespace hapticd::wire {
namespace {

/// Tag and length of Packet.state.
std::string front_of_state(std::size_t bytes) {
  constexpr unsigned kLengthDelimited = 2;
  std::string front{static_cast<char>((v1::Packet::kStateFieldNumber << 3U) | kLengthDelimited)};
  for (; bytes >= 0x80U; bytes >>= 7U) front += static_cast<char>((bytes & 0x7fU) | 0x80U);
  front += static_cast<char>(bytes);
  return front;
}

}  // namespace

bool parse_packet(std::span<const std::uint8_t> body, v1::Packet& packet) {
  // protobuf logs a line about text that is not UTF-8; junk must not fill the log.
  const google::protobuf::LogSilencer silence;
  return packet.ParseFromArray(body.data(), static_cast<int>(body.size())) && packet.first() >= 1 &&
         packet.items_size() <= static_cast<int>(kMaxItems);
}

Channel::Channel(Side side, std::uint32_t session)
    : side_(side),
      session_(session),
      outbox_(side == Side::kServer ? Overtaking::kResults : Overtaking::kNever),
      announces_(side == Side::kClient) {
  if (announces_) inbox_.skip_early();
}

// Opens DATA into `plain`, and lets `body` be that.
bool Channel::open_body(const DatagramHeader& header, std::span<const std::uint8_t>& body,
                        noise::Bytes& plain) const {
  if (!transport_.has_value()) return true;
  std::optional<noise::Bytes> opened =
      transport_->receive.open(header.counter, encode_header(header), body);
  if (!opened.has_value()) return false;
  plain = std::move(*opened);
  body = plain;
  return true;
}

Incoming Channel::receive(const DatagramHeader& header, std::span<const std::uint8_t> body,
                          std::int64_t now_ns) {
  Incoming incoming;
  const bool is_new = window_.is_new(header.counter);
  const bool may_reset =
      side_ == Side::kClient && !transport_.has_value() && body.size() <= kResetBytes;
  if (!is_new && !may_reset) {
    incoming.verdict = Verdict::kRepeated;
    return incoming;
  }
  noise::Bytes plain;
  if (!open_body(header, body, plain)) {
    incoming.verdict = Verdict::kForged;
    return incoming;
  }
  v1::Packet& packet = incoming.packet;
  const bool readable = parse_packet(body, packet);
  if (readable && side_ == Side::kClient && packet.has_reset()) {
    packet.clear_items();
    incoming.verdict = Verdict::kTaken;
    return incoming;
  }
  if (!is_new || !readable) {
    incoming.verdict = is_new ? Verdict::kUnreadable : Verdict::kRepeated;
    packet.Clear();
    return incoming;
  }
  window_.mark(header.counter);
  incoming.verdict = Verdict::kTaken;
  incoming.newest = !any_received_ || header.counter > newest_counter_;
  if (incoming.newest) newest_counter_ = header.counter;
  any_received_ = true;

  if (side_ == Side::kClient) announces_ = false;
  if (packet.ahead() > 0) take_announcement(packet.ahead());
  const std::uint64_t first_before = outbox_.first_id();
  if (!outbox_.acknowledge(packet.ack(), now_ns)) {
    incoming.items.broken = "an Item was acknowledged that was never sent";
    return incoming;
  }
  incoming.progress = outbox_.first_id() != first_before;
  if (incoming.progress) announces_ = false;
  incoming.items = inbox_.take(packet);
  packet.clear_items();
  if (incoming.items.any_new) {
    acknowledge_due_ns_ = 0;
  } else if (incoming.items.any_listed) {
    acknowledge_due_ns_ =
        std::min(acknowledge_due_ns_, std::max(now_ns, left_ns_ + kAcknowledgeAgain_ns));
  }
  return incoming;
}

std::int64_t Channel::due_ns() const noexcept {
  const std::int64_t keep_alive = counter_ == 0 ? 0 : left_ns_ + kKeepAlive_ns;
  return std::min({keep_alive, acknowledge_due_ns_, outbox_.due_ns(kItemsBytes)});
}

// A server announces what a client does, until that has heard it: acknowledged an Item of a Packet.
void Channel::take_announcement(std::uint32_t ahead) {
  outbox_.allow_ahead(ahead);
  if (side_ == Side::kClient) return;
  inbox_.skip_early();
  announces_ = outbox_.first_id() == 1;
}

// What is in every Packet, and without Items.
v1::Packet Channel::front() const {
  v1::Packet front;
  front.set_ack(inbox_.applied());
  front.set_first(outbox_.first_id());
  if (announces_) front.set_ahead(kMaxAhead);
  return front;
}

std::size_t Channel::state_bytes(const v1::Packet& rest) const {
  constexpr std::size_t kTagAndLength = 3;
  return kPacketBytes - front().ByteSizeLong() - rest.ByteSizeLong() - kTagAndLength;
}

bool Channel::write(const v1::Packet& rest, std::int64_t now_ns, std::string& datagram,
                    std::optional<std::string_view> state) {
  outbox_.prepare(now_ns);
  v1::Packet front = this->front();
  const std::string state_front = state.has_value() ? front_of_state(state->size()) : std::string();
  const std::size_t others = rest.ByteSizeLong() + state_front.size() + state.value_or("").size();
  if (front.ByteSizeLong() + others > kPacketBytes) return false;
  const std::uint64_t first = front.first();
  front.set_first(outbox_.leaving_id());
  const std::size_t fixed = front.ByteSizeLong() + others;
  const std::size_t possible = outbox_.fitting(kItemsBytes);
  std::size_t count = fixed <= kPacketBytes ? outbox_.fitting(kPacketBytes - fixed) : 0;
  if (state.has_value() && count < possible) count = 0;
  if (count == 0) front.set_first(first);

  const auto header = encode_header({kind(), session_, counter_});
  // Not by iterators, which would make a string of it first, on the heap.
  datagram.assign(reinterpret_cast<const char*>(header.data()), header.size());
  front.AppendToString(&datagram);
  outbox_.append(count, datagram);
  rest.AppendToString(&datagram);
  datagram += state_front;
  datagram += state.value_or("");
  if (transport_.has_value()) {
    const auto* const plain = reinterpret_cast<const std::uint8_t*>(datagram.data());
    const noise::Bytes sealed = transport_->send.seal(
        counter_, header, {plain + kHeaderBytes, datagram.size() - kHeaderBytes});
    datagram.resize(kHeaderBytes);
    datagram.append(reinterpret_cast<const char*>(sealed.data()), sealed.size());
  }
  outbox_.sent(count, now_ns);
  ++counter_;
  left_ns_ = now_ns;
  acknowledge_due_ns_ = kNever_ns;
  return true;
}

}  // namespace hapticd::wire
