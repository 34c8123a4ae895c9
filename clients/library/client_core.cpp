// See client_core.h.
#include "clients/library/client_core.h"

#include <algorithm>
#include <utility>

#include "proto/wire/whole_characters.h"

namespace hapticd::client {
namespace {

/// A Bye is repeated, and the server's acknowledged, this long, ns.
constexpr std::int64_t kFarewell_ns = 1000 * wire::kMillisecond_ns;
/// Silence of the server after which another session is begun, ns: the server does likewise.
constexpr std::int64_t kSilence_ns = 10'000 * wire::kMillisecond_ns;
/// The same with keys, ns: a server with keys does not answer a session that it does not know.
constexpr std::int64_t kKeyedSilence_ns = 3000 * wire::kMillisecond_ns;
/// The server's clock is asked for with every Packet at first, then so often, ns.
constexpr std::size_t kFirstClocks = 8;
constexpr std::int64_t kClockPeriod_ns = 250 * wire::kMillisecond_ns;
/// States after which a Packet reports them: a Run of steps waits when 64 are unreported.
constexpr std::uint64_t kTellAfterStates = 16;

}  // namespace

ClientCore::ClientCore(Send send, Random random, ClientHandlers handlers,
                       std::optional<ClientKey> key)
    : send_(std::move(send)),
      random_(std::move(random)),
      handlers_(std::move(handlers)),
      key_(key) {
  begin();
}

void ClientCore::begin_keyed() {
  noise::Key ephemeral;
  for (std::size_t i = 0; i < ephemeral.size(); i += 4) {
    const std::uint32_t number = random_();
    for (std::size_t k = 0; k < 4; ++k) {
      ephemeral[i + k] = static_cast<std::uint8_t>(number >> (8 * k));
    }
  }
  handshake_ = std::make_unique<KeyHandshake>(*key_, ephemeral);
  channel_ = std::make_unique<wire::Channel>(wire::Side::kClient, 0);
}

void ClientCore::begin() {
  if (key_.has_value()) {
    begin_keyed();
  } else {
    std::uint32_t number = random_();
    while (number == 0 || (channel_ != nullptr && number == channel_->session())) {
      number = random_();
    }
    channel_ = std::make_unique<wire::Channel>(wire::Side::kClient, number);
  }
  phase_ = Phase::kOpen;
  heard_ns_ = 0;
  boot_id_ = 0;
  states_ = {};
  told_seen_ = 0;
  clock_ = {};
  clocks_sent_ = 0;
  if (!subscription_.has_value()) return;
  v1::Item item;
  *item.mutable_subscribe() = *subscription_;
  channel_->send(item);
}

void ClientCore::end(SessionEnd how) {
  const auto lost = std::exchange(pending_, {});
  for (const auto& [id, done] : lost) {
    if (done) done(nullptr);
  }
  if (handlers_.ended) handlers_.ended(how);
}

void ClientCore::abort(v1::ByeReason reason, const std::string& message, SessionEnd how) {
  v1::Item item;
  item.mutable_bye()->set_reason(reason);
  item.mutable_bye()->set_message(message);
  channel_->send_last(item);
  phase_ = Phase::kDismissed;
  phase_until_ns_ = now_ns_ + kFarewell_ns;
  end(how);
}

bool ClientCore::session_is_over(const v1::Packet& packet) {
  const bool other_boot = boot_id_ != 0 && packet.boot_id() != boot_id_;
  if (!packet.has_reset() && !other_boot) return false;
  const bool full = packet.reset().reason() == v1::RESET_REASON_FULL;
  const bool old = packet.reset().reason() == v1::RESET_REASON_OLD_KEY;
  if (full || old) refusal_ = wire::whole_characters(packet.reset().message(), wire::kMessageBytes);
  const Phase phase = phase_;
  if (phase == Phase::kLeaving) {
    phase_ = Phase::kOver;
    end(SessionEnd::kLeft);
    return true;
  }
  begin();
  if (phase == Phase::kDismissed) return true;  // Its end has been reported.
  const SessionEnd by_reset = full ? SessionEnd::kFull : SessionEnd::kForgotten;
  end(packet.has_reset() ? by_reset : SessionEnd::kRestarted);
  return true;
}

void ClientCore::receive(std::span<const std::uint8_t> datagram, std::int64_t now_ns) {
  now_ns_ = now_ns;
  if (handshake_ != nullptr) {
    if (!handshake_->receive(datagram)) return;
    channel_->secure(handshake_->session(), handshake_->transport());
    handshake_.reset();
    heard_ns_ = now_ns;
    return;
  }
  const auto header = wire::decode_header(datagram);
  if (!header.has_value() || header->kind != channel_->kind() ||
      header->session != channel_->session() || phase_ == Phase::kOver) {
    return;
  }
  wire::Incoming incoming =
      channel_->receive(*header, datagram.subspan(wire::kHeaderBytes), now_ns);
  if (incoming.verdict != wire::Verdict::kTaken) return;
  v1::Packet& packet = incoming.packet;
  if (session_is_over(packet)) return;
  heard_ns_ = now_ns;
  boot_id_ = packet.boot_id();
  if (packet.has_clock()) {
    const auto sample = wire::clock_sample(packet.clock(), now_ns);
    if (sample.has_value()) clock_.add(*sample);
  }
  for (wire::ReceivedItem& received : incoming.items.items) {
    if (phase_ != Phase::kOpen && phase_ != Phase::kLeaving) return;
    apply(received);
  }
  if (incoming.items.broken != nullptr) {
    if (phase_ == Phase::kOpen) {
      abort(v1::BYE_REASON_PROTOCOL_ERROR, incoming.items.broken, SessionEnd::kProtocolError);
    }
    return;
  }
  if (!packet.has_state() || phase_ != Phase::kOpen) return;
  const auto state = states_.take(std::move(*packet.mutable_state()), incoming.newest);
  if (state.has_value() && handlers_.state) handlers_.state(*state);
}

void ClientCore::apply(wire::ReceivedItem& received) {
  const v1::Item& item = received.item;
  if (item.has_result()) {
    take_result(item.result());
  } else if (item.has_bye()) {
    bye_ = item.bye();
    const bool was_leaving = phase_ == Phase::kLeaving;
    phase_ = Phase::kDismissed;
    phase_until_ns_ = now_ns_ + kFarewell_ns;
    if (was_leaving) phase_ = Phase::kOver;
    end(was_leaving ? SessionEnd::kLeft : SessionEnd::kBye);
  } else if (item.body_case() != v1::Item::BODY_NOT_SET && handlers_.item) {
    handlers_.item(item);
  }
}

void ClientCore::take_result(const v1::Result& result) {
  const auto pending = pending_.find(result.item_id());
  if (pending == pending_.end()) {
    if (handlers_.pose_refused && result.code() != v1::RESULT_CODE_OK) {
      handlers_.pose_refused(result);
    }
    return;
  }
  const ResultHandler done = std::move(pending->second);
  pending_.erase(pending);
  if (done) done(&result);
}

std::uint64_t ClientCore::request(const v1::Item& item, ResultHandler done) {
  if (phase_ != Phase::kOpen) return 0;
  const auto id = channel_->send(item);
  if (!id.has_value()) {
    abort(v1::BYE_REASON_BACKLOG, "more Items than were acknowledged in time",
          SessionEnd::kBacklog);
    return 0;
  }
  if (item.has_subscribe()) subscription_ = item.subscribe();
  if (!item.has_pose_batch()) pending_.emplace(*id, std::move(done));
  return *id;
}

void ClientCore::leave(std::int64_t now_ns) {
  if (phase_ != Phase::kOpen) {
    phase_ = phase_ == Phase::kDismissed ? Phase::kOver : phase_;
    return;
  }
  now_ns_ = now_ns;
  v1::Item item;
  item.mutable_bye()->set_reason(v1::BYE_REASON_DONE);
  channel_->send_last(item);
  phase_ = Phase::kLeaving;
  phase_until_ns_ = now_ns + kFarewell_ns;
}

std::int64_t ClientCore::due_ns() const {
  if (phase_ == Phase::kOver) return wire::kNever_ns;
  if (phase_ == Phase::kLeaving && channel_->all_acknowledged()) return 0;
  if (phase_ == Phase::kOpen && states_.seen() - told_seen_ >= kTellAfterStates) return 0;
  const std::int64_t due = handshake_ != nullptr ? handshake_->due_ns() : channel_->due_ns();
  return phase_ == Phase::kOpen ? due : std::min(due, phase_until_ns_);
}

void ClientCore::poll(std::int64_t now_ns) {
  now_ns_ = now_ns;
  if (phase_ == Phase::kLeaving && (channel_->all_acknowledged() || now_ns >= phase_until_ns_)) {
    phase_ = Phase::kOver;
    end(SessionEnd::kLeft);
  }
  if (phase_ == Phase::kDismissed && now_ns >= phase_until_ns_) begin();
  const std::int64_t silence_ns = key_.has_value() ? kKeyedSilence_ns : kSilence_ns;
  if (phase_ == Phase::kOpen && heard() && now_ns - heard_ns_ > silence_ns) {
    begin();
    end(SessionEnd::kSilence);
  }
  if (due_ns() > now_ns) return;
  if (handshake_ != nullptr) {
    send_(handshake_->hello(now_ns));
    return;
  }
  // Further ones leave for Items alone.
  for (std::size_t i = 0; i < wire::kMaxAhead && (i == 0 || channel_->due_ns() <= now_ns); ++i) {
    if (!send_packet()) return;
  }
}

bool ClientCore::send_packet() {
  v1::Packet packet;
  packet.set_seen(states_.seen());
  packet.set_newest(states_.newest());
  if (clocks_sent_ < kFirstClocks || now_ns_ - clock_sent_ns_ >= kClockPeriod_ns) {
    packet.mutable_clock()->set_sent_ns(static_cast<std::uint64_t>(now_ns_));
    clock_sent_ns_ = now_ns_;
    ++clocks_sent_;
  }
  if (!channel_->write(packet, now_ns_, datagram_)) return false;
  told_seen_ = states_.seen();
  send_({reinterpret_cast<const std::uint8_t*>(datagram_.data()), datagram_.size()});
  return true;
}

}  // namespace hapticd::client
