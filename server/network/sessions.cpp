// See sessions.h.
#include "server/network/sessions.h"

#include <algorithm>
#include <utility>

#include "server/network/untold_item.h"

namespace hapticd {
namespace {

/// Sessions at once, those that say goodbye included.
constexpr std::size_t kMaxSessions = 32;
/// Of them, places that those who only look cannot hold: somebody may have to say Stop.
constexpr std::size_t kControlPlaces = 8;
constexpr std::size_t kMaxLookers = kMaxSessions - kControlPlaces;
/// Of the lookers' places, those of one address.
constexpr std::size_t kMaxLookersOfAddress = kMaxLookers / 4;
/// A session unheard for longer is idler than any that is heard, ns.
constexpr std::int64_t kUnheard_ns = 1000 * wire::kMillisecond_ns;
/// Silence after which a session is dropped, ns.
constexpr std::int64_t kDropAfter_ns = 10'000 * wire::kMillisecond_ns;
/// How long a Bye is repeated, and how long the other side's is acknowledged, ns. While the Items
/// before a Bye are still being acknowledged its time restarts, but ends after kLongFarewell_ns.
constexpr std::int64_t kFarewell_ns = 1000 * wire::kMillisecond_ns;
constexpr std::int64_t kLongFarewell_ns = 10'000 * wire::kMillisecond_ns;
/// Packets of one session in a poll, and beyond the first of each those of all sessions: while they
/// are sent, nobody's Stop is heard.
constexpr std::size_t kMaxPackets = wire::kMaxAhead;
constexpr std::size_t kMaxFurtherPackets = 64;
/// A Run of steps that waits repeats the newest State so often, ns.
constexpr std::int64_t kRepeatState_ns = 50 * wire::kMillisecond_ns;

/// What somebody hears for whom there is no place.
v1::Reset full_reset() {
  v1::Reset reset;
  reset.set_reason(v1::RESET_REASON_FULL);
  reset.set_message("all places are taken: end another client first");
  return reset;
}

/// What a client of 0.1 hears. Its user has to be told what to do.
v1::Reset old_key_reset() {
  v1::Reset reset;
  reset.set_reason(v1::RESET_REASON_OLD_KEY);
  reset.set_message(
      "this daemon proves who it is, which your client or key file is too old for: run 'hapticctl "
      "keygen' on the daemon's folder of keys, take the key file from there again, and use a "
      "client "
      "of the daemon's version");
  return reset;
}

}  // namespace

Sessions::Sessions(const ServerOptions& options, Send send, SessionHandlers handlers)
    : boot_id_(options.boot_id),
      old_handshake_(options.old_handshake),
      send_(std::move(send)),
      handlers_(std::move(handlers)) {
  if (options.keys.has_value()) {
    handshakes_ = std::make_unique<Handshakes>(*options.keys, options.random);
  }
}

Session* Sessions::find(const Address& address, std::uint32_t number) const {
  for (const auto& session : sessions_) {
    if (session->phase != Phase::kGone && session->channel.session() == number &&
        session->address == address) {
      return session.get();
    }
  }
  return nullptr;
}

Session* Sessions::find(std::uint64_t serial) const {
  for (const auto& session : sessions_) {
    if (session->serial == serial) return session.get();
  }
  return nullptr;
}

// In the clear everyone may control. Of those who have never asked to, the first one beyond the
// places they can hold; null: there is none.
Session* Sessions::surplus_looker() const {
  std::size_t lookers = 0;
  for (const auto& session : sessions_) {
    const bool looks = session->phase == Phase::kOpen && !session->asked_control;
    if (looks && ++lookers > kMaxLookers) return session.get();
  }
  return nullptr;
}

// Of the sessions of the view key that `counts` the one that has asked for nothing for longest, and
// before all of them one that is not heard; null: there is none.
template <typename Counts>
Session* Sessions::idlest_viewer(const Counts& counts) const {
  const auto idle = [this](const Session& session) {
    const bool unheard = now_ns_ - session.heard_ns > kUnheard_ns;
    return std::pair(!unheard, session.asked_ns);
  };
  Session* idlest = nullptr;
  for (const auto& session : sessions_) {
    if (session->phase != Phase::kOpen || session->role != wire::Role::kView || !counts(*session)) {
      continue;
    }
    if (idlest == nullptr || idle(*session) < idle(*idlest)) idlest = session.get();
  }
  return idlest;
}

std::size_t Sessions::viewers_of(const Address& address) const {
  return static_cast<std::size_t>(
      std::count_if(sessions_.begin(), sessions_.end(), [&](const auto& session) {
        return session->phase == Phase::kOpen && session->role == wire::Role::kView &&
               same_network(session->address, address);
      }));
}

// A place of those that look, for one more of the view key. One address holds a quarter of them at
// most; this machine's own may hold more for as long as no other wants them.
bool Sessions::make_looker_place(const Address& from) {
  const bool within = viewers_of(from) < kMaxLookersOfAddress;
  if (!within && !is_loopback(from)) return false;
  const auto views = std::count_if(sessions_.begin(), sessions_.end(), [](const auto& session) {
    return session->phase == Phase::kOpen && session->role == wire::Role::kView;
  });
  if (static_cast<std::size_t>(views) < kMaxLookers) return true;
  Session* giving = idlest_viewer([&](const Session& session) {
    return within && viewers_of(session.address) > kMaxLookersOfAddress;
  });
  if (giving == nullptr) return false;
  evict(*giving, "gave way to a viewer from another address");
  return true;
}

// Room for one more session of this role.
bool Sessions::make_room(const Address& from, wire::Role role) {
  if (role == wire::Role::kView && !make_looker_place(from)) return false;
  if (sessions_.size() < kMaxSessions) return true;
  // Of those that say goodbye the one that began first gives way.
  const auto leaving =
      std::min_element(sessions_.begin(), sessions_.end(), [](const auto& a, const auto& b) {
        return (a->phase == Phase::kOpen ? wire::kNever_ns : a->phase_until_ns) <
               (b->phase == Phase::kOpen ? wire::kNever_ns : b->phase_until_ns);
      });
  if ((*leaving)->phase != Phase::kOpen) {
    remove(**leaving);
    return true;
  }
  Session* giving = nullptr;
  if (handshakes_ == nullptr) {
    giving = surplus_looker();
  } else if (role == wire::Role::kControl) {
    giving = idlest_viewer([](const Session& /*session*/) { return true; });
  }
  if (giving == nullptr) return false;
  evict(*giving, "gave way: all places are taken, and some are kept for those who control");
  return true;
}

// Its client is told why, in its own session, and once.
void Sessions::evict(Session& session, const char* why) {
  ++counters_.evicted;
  end(session, Phase::kGone);
  v1::Reset reset;
  reset.set_reason(v1::RESET_REASON_FULL);
  reset.set_message(why);
  if (handshakes_ == nullptr) {
    refuse(session.address, session.channel.session(), reset);
  } else {
    ++counters_.resets;
    v1::Packet packet;
    *packet.mutable_reset() = reset;
    transmit(session, packet);
  }
  remove(session);
}

void Sessions::remove(Session& session) {
  if (handshakes_ != nullptr) handshakes_->forget(session.channel.session());
  std::erase_if(sessions_, [&](const auto& each) { return each.get() == &session; });
}

// `half`: the handshake that led to it; null: PLAIN, which may control.
Session* Sessions::open(const Address& from, std::uint32_t number, const HalfOpen* half) {
  const wire::Role role = half == nullptr ? wire::Role::kControl : half->role;
  if (!make_room(from, role)) {
    ++counters_.full;
    return nullptr;
  }
  sessions_.push_back(std::make_unique<Session>(++opened_, from, number));
  Session& session = *sessions_.back();
  session.heard_ns = now_ns_;
  session.asked_ns = now_ns_;
  session.role = role;
  if (half != nullptr) {
    session.key_id = half->key_id;
    session.key_name = half->key_name;
  }
  serve(session, [&] { handlers_.opened(session); });
  return &session;
}

void Sessions::send_datagram(const Address& to) {
  ++counters_.sent;
  send_(to, {reinterpret_cast<const std::uint8_t*>(datagram_.data()), datagram_.size()});
}

void Sessions::refuse(const Address& to, std::uint32_t number, const v1::Reset& reset) {
  if (!reset_limiter_.allow(to, now_ns_)) {
    ++counters_.resets_limited;
    return;
  }
  v1::Packet packet;
  packet.set_first(1);
  packet.set_boot_id(boot_id_);
  *packet.mutable_reset() = reset;
  const auto header = wire::encode_header({wire::DatagramKind::kPlain, number, 0});
  datagram_.assign(header.begin(), header.end());
  packet.AppendToString(&datagram_);
  ++counters_.resets;
  send_datagram(to);
}

// The only DATA of a session that is not served.
void Sessions::refuse_keyed(const HalfOpen& half, const v1::Reset& reset) {
  wire::Channel channel(wire::Side::kServer, half.session);
  channel.secure(half.session, half.transport);
  v1::Packet packet;
  packet.set_boot_id(boot_id_);
  *packet.mutable_reset() = reset;
  if (!channel.write(packet, now_ns_, datagram_)) return;
  ++counters_.resets;
  send_datagram(half.address);
}

Session* Sessions::session_for(const Address& from, const wire::DatagramHeader& header,
                               std::span<const std::uint8_t> body) {
  Session* session = find(from, header.session);
  if (session != nullptr) return session;
  ++counters_.unknown_session;
  v1::Packet packet;
  if (header.session == 0 || shutting_down_ || !wire::parse_packet(body, packet)) return nullptr;
  if (packet.first() != 1 || packet.ack() != 0) {
    v1::Reset unknown;
    unknown.set_reason(v1::RESET_REASON_UNKNOWN_SESSION);
    refuse(from, header.session, unknown);
    return nullptr;
  }
  session = open(from, header.session, nullptr);
  if (session == nullptr) {
    refuse(from, header.session, full_reset());
  } else {
    --counters_.unknown_session;
  }
  return session;
}

// PROTOCOL.md, section 12.
Session* Sessions::keyed_session_for(const Address& from, const wire::DatagramHeader& header,
                                     std::span<const std::uint8_t> body) {
  Session* session = find(from, header.session);
  if (session != nullptr) return session;
  const HalfOpen* half = shutting_down_ ? nullptr : handshakes_->find(from, header.session);
  if (half == nullptr) {
    ++counters_.unknown_session;
    return nullptr;
  }
  return open_keyed(HalfOpen(*half), header, body);
}

void Sessions::receive_hello(const Address& from, std::span<const std::uint8_t> received) {
  if (shutting_down_) return;
  const noise::Bytes answer = handshakes_->receive(from, received, now_ns_);
  counters_.hellos = handshakes_->counters();
  if (answer.empty()) return;
  ++counters_.sent;
  send_(from, answer);
}

// The session of a handshake, when `body` is a DATA of it that opens: the client is there, and not
// only somebody who sends what it sent before.
Session* Sessions::open_keyed(const HalfOpen& half, const wire::DatagramHeader& header,
                              std::span<const std::uint8_t> body) {
  const auto plain = half.transport.receive.open(header.counter, wire::encode_header(header), body);
  if (!plain.has_value()) {
    ++counters_.forged;
    return nullptr;
  }
  v1::Packet packet;
  if (!wire::parse_packet(*plain, packet)) {
    ++counters_.unreadable;
    return nullptr;
  }
  const bool too_old = half.method == wire::Method::kNNpsk0 && !old_handshake_;
  if (too_old) ++counters_.old_keys;
  Session* session = too_old ? nullptr : open(half.address, half.session, &half);
  if (session == nullptr) {
    refuse_keyed(half, too_old ? old_key_reset() : full_reset());
    handshakes_->forget(half.session);
    return nullptr;
  }
  session->channel.secure(half.session, half.transport);
  handshakes_->establish(half.session);
  return session;
}

bool Sessions::count_verdict(wire::Verdict verdict) {
  switch (verdict) {
    case wire::Verdict::kRepeated:
      ++counters_.repeated;
      break;
    case wire::Verdict::kUnreadable:
      ++counters_.unreadable;
      break;
    case wire::Verdict::kForged:
      ++counters_.forged;
      break;
    case wire::Verdict::kTaken:
      return true;
  }
  return false;
}

std::optional<ArrivedPacket> Sessions::receive(const Address& from,
                                               std::span<const std::uint8_t> datagram) {
  ++counters_.received;
  const auto header = wire::decode_header(datagram);
  const bool keyed = handshakes_ != nullptr;
  if (header.has_value() && keyed && header->kind == wire::DatagramKind::kHello) {
    receive_hello(from, datagram);
    return std::nullopt;
  }
  const auto kind = keyed ? wire::DatagramKind::kData : wire::DatagramKind::kPlain;
  if (!header.has_value() || header->kind != kind) {
    ++counters_.bad_header;
    return std::nullopt;
  }
  const std::span<const std::uint8_t> body = datagram.subspan(wire::kHeaderBytes);
  Session* session =
      keyed ? keyed_session_for(from, *header, body) : session_for(from, *header, body);
  if (session == nullptr) return std::nullopt;
  ArrivedPacket arrived{session, session->channel.receive(*header, body, now_ns_)};
  if (!count_verdict(arrived.incoming.verdict)) return std::nullopt;
  session->heard_ns = now_ns_;
  if (!arrived.incoming.items.items.empty()) session->asked_ns = now_ns_;
  if (session->phase == Phase::kLeaving && arrived.incoming.progress) {
    session->phase_until_ns =
        std::min(now_ns_ + kFarewell_ns, session->phase_since_ns + kLongFarewell_ns);
  }
  return arrived;
}

void Sessions::transmit(Session& session, v1::Packet& rest, std::optional<std::string_view> state) {
  rest.set_boot_id(boot_id_);
  session.clock.fill(rest, now_ns_);
  if (session.channel.write(rest, now_ns_, datagram_, state)) send_datagram(session.address);
}

std::size_t Sessions::state_bytes(const Session& session) const {
  v1::Packet frame;  // As long as the Packet gets without the State.
  frame.set_boot_id(boot_id_);
  wire::ClockEcho(session.clock).fill(frame, now_ns_);
  return session.channel.state_bytes(frame);
}

void Sessions::send_states(Session& session, const EncodedState& state) {
  for (const std::string& part : state.parts) {
    v1::Packet packet;
    transmit(session, packet, part);
  }
}

void Sessions::poll_session(Session& session) {
  if (session.phase == Phase::kOpen && now_ns_ - session.heard_ns > kDropAfter_ns) {
    ++counters_.silences;
    close(session, v1::BYE_REASON_SILENCE, "nothing was heard for 10 s");
    session.phase_until_ns = now_ns_;  // One Bye, in case somebody is still there.
  }
  // A session is remembered while datagrams of it may be under way: a late duplicate of its first
  // one would open it again, and its requests would be carried out twice.
  const bool over =
      session.phase != Phase::kOpen &&
      (now_ns_ > session.phase_until_ns || (shutting_down_ && session.channel.all_acknowledged()));
  if (over) {
    session.phase = Phase::kGone;
    return;
  }
  const StateFlow& flow = session.flow;
  if (session.runs_steps() && flow.ahead() >= kMaxStatesAhead &&
      now_ns_ - flow.sent_ns() >= kRepeatState_ns && session.newest_state != nullptr) {
    send_states(session, *session.newest_state);
    session.flow.repeated(session.newest_state->parts.size(), now_ns_);
  }
  if (session.channel.due_ns() <= now_ns_) {
    v1::Packet packet;
    transmit(session, packet);
  }
}

// What is due beyond the first Packet of each leaves in turns, so that a long answer to one keeps
// no other waiting.
void Sessions::send_further() {
  std::size_t left = kMaxFurtherPackets;
  bool any = true;
  for (std::size_t turn = 1; turn < kMaxPackets && any; ++turn) {
    any = false;
    for (const auto& session : sessions_) {
      if (session->phase == Phase::kGone || session->channel.due_ns() > now_ns_) continue;
      if (left-- == 0) return;
      v1::Packet packet;
      any = within_memory([&] { transmit(*session, packet); }) || any;
    }
  }
}

void Sessions::poll() {
  // A Packet that could not be written has not left: it is due again.
  for (const auto& session : sessions_) within_memory([&] { poll_session(*session); });
  send_further();
  if (handshakes_ != nullptr) {
    handshakes_->expire(now_ns_);
    for (const auto& session : sessions_) {
      if (session->phase == Phase::kGone) handshakes_->forget(session->channel.session());
    }
  }
  std::erase_if(sessions_, [](const auto& session) { return session->phase == Phase::kGone; });
}

void Sessions::tell(Session& session, const v1::Item& item) {
  if (session.phase != Phase::kOpen) return;
  serve(session, [&] {
    if (session.channel.send(item).has_value()) return;
    const std::optional<v1::Item> notice = notice_for(item);
    if (notice.has_value() && session.channel.send(*notice).has_value()) {
      ++counters_.untold;
      return;
    }
    ++counters_.backlogs;
    close(session, v1::BYE_REASON_BACKLOG, "more Items than were acknowledged in time");
  });
}

void Sessions::tell_all(const v1::Item& item) {
  for (const auto& session : sessions_) tell(*session, item);
}

void Sessions::close(Session& session, v1::ByeReason reason, const std::string& message) {
  if (session.phase != Phase::kOpen) return;
  serve(session, [&] {
    v1::Item item;
    item.mutable_bye()->set_reason(reason);
    item.mutable_bye()->set_message(message);
    session.channel.send_last(item);
    end(session, Phase::kLeaving);
  });
}

void Sessions::fall(Session& session) {
  if (session.phase == Phase::kOpen) {
    ++counters_.fallen;
    end(session, Phase::kGone);
  }
  session.phase = Phase::kGone;
}

void Sessions::fall(const Address& from, std::span<const std::uint8_t> datagram) {
  const auto header = wire::decode_header(datagram);
  Session* session = header.has_value() ? find(from, header->session) : nullptr;
  if (session != nullptr) fall(*session);
}

void Sessions::replace_keys(const noise::ServerKeys& keys) {
  if (handshakes_ == nullptr) return;
  handshakes_->replace_keys(keys);
  for (const auto& session : sessions_) {
    const bool stays =
        !session->key_id.has_value() || handshakes_->holds(*session->key_id, session->role);
    if (session->phase != Phase::kOpen || stays) continue;
    ++counters_.revoked;
    close(*session, v1::BYE_REASON_REVOKED,
          "the key " + session->key_name + " was revoked: ask who runs hapticd for another");
  }
}

void Sessions::shut_down(v1::ByeReason reason, const std::string& message) {
  shutting_down_ = true;
  for (const auto& session : sessions_) close(*session, reason, message);
}

void Sessions::end(Session& session, Phase phase) {
  session.phase = phase;
  session.phase_since_ns = now_ns_;
  session.phase_until_ns = now_ns_ + kFarewell_ns;
  session.flow.subscribe({});
  handlers_.ended(session);
}

}  // namespace hapticd
