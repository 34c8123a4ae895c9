// See protocol_server.h: sessions and datagrams.
#include "server/network/protocol_server.h"

#include <algorithm>
#include <array>
#include <utility>

#include "server/network/protocol_state.h"
#include "server/network/untold_item.h"

namespace hapticd {

using Implementation = ProtocolServer::Implementation;

Session* Implementation::find(const Address& address, std::uint32_t number) {
  for (const auto& session : sessions) {
    if (session->phase != Phase::kGone && session->channel.session() == number &&
        session->address == address) {
      return session.get();
    }
  }
  return nullptr;
}

Session* Implementation::find(std::uint64_t serial) {
  for (const auto& session : sessions) {
    if (session->serial == serial) return session.get();
  }
  return nullptr;
}

// Of those who may only look, and in the clear of those who have never asked for more, the first
// one beyond the places they can hold; null: there is none.
Session* Implementation::surplus_looker() {
  std::size_t lookers = 0;
  for (const auto& session : sessions) {
    const bool looks =
        handshakes == nullptr ? !session->asked_control : session->role == wire::Role::kView;
    if (session->phase == Phase::kOpen && looks && ++lookers > kMaxLookers) return session.get();
  }
  return nullptr;
}

// Room for one more session of this role.
bool Implementation::make_room(wire::Role role) {
  if (role == wire::Role::kView) {
    const auto views = std::count_if(sessions.begin(), sessions.end(), [](const auto& session) {
      return session->phase == Phase::kOpen && session->role == wire::Role::kView;
    });
    if (static_cast<std::size_t>(views) >= kMaxLookers) return false;
  }
  if (sessions.size() < kMaxSessions) return true;
  // Of those that say goodbye the one that began first gives way.
  auto giving =
      std::min_element(sessions.begin(), sessions.end(), [](const auto& a, const auto& b) {
        return (a->phase == Phase::kOpen ? wire::kNever_ns : a->phase_until_ns) <
               (b->phase == Phase::kOpen ? wire::kNever_ns : b->phase_until_ns);
      });
  if ((*giving)->phase == Phase::kOpen) {
    const Session* surplus = surplus_looker();
    if (surplus == nullptr) return false;
    giving = std::find_if(sessions.begin(), sessions.end(),
                          [&](const auto& session) { return session.get() == surplus; });
    end(**giving, Phase::kGone);
    refuse((*giving)->address, (*giving)->channel.session(), v1::RESET_REASON_FULL);
  }
  if (handshakes != nullptr) handshakes->forget((*giving)->channel.session());
  sessions.erase(giving);
  return true;
}

Session* Implementation::open(const Address& from, std::uint32_t number, wire::Role role) {
  if (!make_room(role)) return nullptr;
  sessions.push_back(std::make_unique<Session>(++sessions_opened, from, number));
  Session& session = *sessions.back();
  session.heard_ns = now_ns;
  session.role = role;
  bool first = true;
  for (const v1::Item& item : host.greeting()) {
    note_scene(item);
    tell(session, item);
    if (!std::exchange(first, false)) continue;
    v1::Item lease_item;
    *lease_item.mutable_lease_info() = lease_info(session);
    tell(session, lease_item);
  }
  return &session;
}

void Implementation::refuse(const Address& to, std::uint32_t number, v1::ResetReason reason) {
  if (!reset_limiter.allow(to, now_ns)) return;
  v1::Packet packet;
  packet.set_first(1);
  packet.set_boot_id(options.boot_id);
  packet.mutable_reset()->set_reason(reason);
  const auto header = wire::encode_header({wire::DatagramKind::kPlain, number, 0});
  datagram.assign(header.begin(), header.end());
  packet.AppendToString(&datagram);
  ++counters.resets;
  ++counters.sent;
  send(to, {reinterpret_cast<const std::uint8_t*>(datagram.data()), datagram.size()});
}

Session* Implementation::session_for(const Address& from, const wire::DatagramHeader& header,
                                     std::span<const std::uint8_t> body) {
  Session* session = find(from, header.session);
  if (session != nullptr) return session;
  ++counters.unknown_session;
  v1::Packet packet;
  if (header.session == 0 || shutting_down || !wire::parse_packet(body, packet)) return nullptr;
  if (packet.first() != 1 || packet.ack() != 0) {
    refuse(from, header.session, v1::RESET_REASON_UNKNOWN_SESSION);
    return nullptr;
  }
  session = open(from, header.session, wire::Role::kControl);
  if (session == nullptr) {
    refuse(from, header.session, v1::RESET_REASON_FULL);
  } else {
    --counters.unknown_session;
  }
  return session;
}

void Implementation::receive_body(Session& session, const wire::DatagramHeader& header,
                                  std::span<const std::uint8_t> body) {
  wire::Incoming incoming = session.channel.receive(header, body, now_ns);
  switch (incoming.verdict) {
    case wire::Verdict::kRepeated:
      ++counters.repeated;
      break;
    case wire::Verdict::kUnreadable:
      ++counters.unreadable;
      break;
    case wire::Verdict::kForged:
      ++counters.forged;
      break;
    case wire::Verdict::kTaken:
      take(session, incoming);
      break;
  }
}

void Implementation::take(Session& session, wire::Incoming& incoming) {
  session.heard_ns = now_ns;
  if (holds_lease(session)) lease.renewed_ns = now_ns;
  if (session.phase == Phase::kLeaving && incoming.progress) {
    session.phase_until_ns =
        std::min(now_ns + kFarewell_ns, session.phase_since_ns + kLongFarewell_ns);
  }
  const v1::Packet& packet = incoming.packet;
  if (packet.has_clock()) session.clock.take(packet.clock(), now_ns);
  if (incoming.newest) {
    session.flow.told(packet.seen(), packet.newest(), !options.virtual_clock, now_ns);
  }
  for (wire::ReceivedItem& received : incoming.items.items) {
    if (session.phase != Phase::kOpen) return;
    apply(session, received);
  }
  if (incoming.items.broken != nullptr && session.phase == Phase::kOpen) {
    ++counters.protocol_errors;
    close(session, v1::BYE_REASON_PROTOCOL_ERROR, incoming.items.broken);
  }
}

void Implementation::transmit(Session& session, v1::Packet& rest,
                              std::optional<std::string_view> state) {
  rest.set_boot_id(options.boot_id);
  session.clock.fill(rest, now_ns);
  if (!session.channel.write(rest, now_ns, datagram, state)) return;
  ++counters.sent;
  send(session.address, {reinterpret_cast<const std::uint8_t*>(datagram.data()), datagram.size()});
}

void Implementation::send_states(Session& session, const EncodedState& state) {
  for (const std::string& part : state.parts) {
    v1::Packet packet;
    transmit(session, packet, part);
  }
}

void Implementation::poll_session(Session& session) {
  if (session.phase == Phase::kOpen && now_ns - session.heard_ns > kDropAfter_ns) {
    ++counters.silences;
    close(session, v1::BYE_REASON_SILENCE, "nothing was heard for 10 s");
    session.phase_until_ns = now_ns;  // One Bye, in case somebody is still there.
  }
  // A session is remembered while datagrams of it may be under way: a late duplicate of its first
  // one would open it again, and its requests would be carried out twice.
  const bool over =
      session.phase != Phase::kOpen &&
      (now_ns > session.phase_until_ns || (shutting_down && session.channel.all_acknowledged()));
  if (over) {
    session.phase = Phase::kGone;
    return;
  }
  const StateFlow& flow = session.flow;
  if (session.runs_steps() && flow.ahead() >= kMaxStatesAhead &&
      now_ns - flow.sent_ns() >= kRepeatState_ns && session.newest_state != nullptr) {
    send_states(session, *session.newest_state);
    session.flow.repeated(session.newest_state->parts.size(), now_ns);
  }
  if (session.channel.due_ns() <= now_ns) {
    v1::Packet packet;
    transmit(session, packet);
  }
}

void Implementation::tell(Session& session, const v1::Item& item) {
  if (session.phase != Phase::kOpen || session.channel.send(item).has_value()) return;
  const std::optional<v1::Item> notice = notice_for(item);
  if (notice.has_value() && session.channel.send(*notice).has_value()) {
    ++counters.untold;
    return;
  }
  ++counters.backlogs;
  close(session, v1::BYE_REASON_BACKLOG, "more Items than were acknowledged in time");
}

void Implementation::tell_all(const v1::Item& item) {
  for (const auto& session : sessions) tell(*session, item);
}

void Implementation::note_scene(const v1::Item& item) {
  if (!item.has_scene_info()) return;
  rest_radii_m.clear();
  for (const v1::String& string : item.scene_info().scene().strings()) {
    rest_radii_m.push_back(string.radius_m());
  }
}

void Implementation::close(Session& session, v1::ByeReason reason, const std::string& message) {
  if (session.phase != Phase::kOpen) return;
  v1::Item item;
  item.mutable_bye()->set_reason(reason);
  item.mutable_bye()->set_message(message);
  session.channel.send_last(item);
  end(session, Phase::kLeaving);
}

void Implementation::end(Session& session, Phase phase) {
  session.phase = phase;
  session.phase_since_ns = now_ns;
  session.phase_until_ns = now_ns + kFarewell_ns;
  session.waiting.clear();
  session.waiting_bytes = 0;
  session.flow.subscribe({});
  abandon_requests(session);
  if (holds_lease(session)) end_lease(LeaseEnd::kSessionEnded);
}

ProtocolServer::ProtocolServer(const ServerOptions& options, ServerHost host, Send send)
    : implementation_(std::make_unique<Implementation>()) {
  implementation_->options = options;
  if (options.keys.has_value()) {
    implementation_->handshakes = std::make_unique<Handshakes>(*options.keys, options.random);
  }
  implementation_->host = std::move(host);
  implementation_->send = std::move(send);
}

ProtocolServer::~ProtocolServer() = default;

void ProtocolServer::receive(const Address& from, std::span<const std::uint8_t> datagram,
                             std::int64_t now_ns) {
  Implementation& self = *implementation_;
  self.now_ns = now_ns;
  ServerCounters& counters = self.counters;
  ++counters.received;
  const auto header = wire::decode_header(datagram);
  if (header.has_value() && self.handshakes != nullptr) {
    self.receive_keyed(from, *header, datagram);
    return;
  }
  if (!header.has_value() || header->kind != wire::DatagramKind::kPlain) {
    ++counters.bad_header;
    return;
  }
  const std::span<const std::uint8_t> body = datagram.subspan(wire::kHeaderBytes);
  Session* session = self.session_for(from, *header, body);
  if (session != nullptr) self.receive_body(*session, *header, body);
}

void ProtocolServer::poll(std::int64_t now_ns) {
  Implementation& self = *implementation_;
  self.now_ns = now_ns;
  self.expire_lease();
  self.serve_costly();
  for (const auto& session : self.sessions) self.poll_session(*session);
  if (self.handshakes != nullptr) {
    self.handshakes->expire(now_ns);
    for (const auto& session : self.sessions) {
      if (session->phase == Phase::kGone) self.handshakes->forget(session->channel.session());
    }
  }
  std::erase_if(self.sessions, [](const auto& session) { return session->phase == Phase::kGone; });
}

void ProtocolServer::broadcast(const v1::Item& item) {
  implementation_->note_scene(item);
  implementation_->tell_all(item);
}

void ProtocolServer::answer(const RequestId& id, v1::Result result) {
  implementation_->answer(id, std::move(result));
}

void ProtocolServer::offer_tick(std::uint64_t tick, std::uint32_t scene_id, std::int64_t now_ns) {
  Implementation& self = *implementation_;
  self.now_ns = now_ns;
  self.encoded_states.begin(tick, scene_id);
  for (const auto& pointer : self.sessions) {
    Session& session = *pointer;
    if (session.phase != Phase::kOpen ||
        !session.flow.wants(tick, now_ns - session.heard_ns, now_ns)) {
      continue;
    }
    v1::Packet frame;  // As long as the Packet gets without the State.
    frame.set_boot_id(self.options.boot_id);
    wire::ClockEcho(session.clock).fill(frame, now_ns);
    std::shared_ptr<const EncodedState> state =
        self.encoded_states.get(session.flow.subscription(), session.channel.state_bytes(frame),
                                self.host.fill_state, self.rest_radii_m);
    self.counters.unfit_states += state->unfit;
    session.flow.sent(tick, scene_id, state->parts.size(), now_ns);
    self.send_states(session, *state);
    if (self.options.virtual_clock) session.newest_state = std::move(state);
  }
}

bool ProtocolServer::may_step(std::int64_t now_ns) {
  bool may = true;
  for (const auto& session : implementation_->sessions) {
    if (session->phase != Phase::kOpen) continue;
    const bool runs = session->runs_steps();
    if (runs && session->flow.ahead() >= kMaxStatesAhead) may = false;
    const wire::Channel& channel = session->channel;
    ItemFlow& items = session->items;
    items.note(channel.unacknowledged(), channel.acknowledged(), now_ns);
    if (items.behind() && (runs || items.progresses(now_ns))) may = false;
  }
  return may;
}

void ProtocolServer::shut_down(v1::ByeReason reason, const std::string& message,
                               std::int64_t now_ns) {
  Implementation& self = *implementation_;
  self.now_ns = now_ns;
  self.shutting_down = true;
  for (const auto& session : self.sessions) self.close(*session, reason, message);
}

std::size_t ProtocolServer::session_count() const { return implementation_->sessions.size(); }

const std::string& ProtocolServer::lease_holder() const { return implementation_->lease.holder; }

std::uint64_t ProtocolServer::fence() const {
  return implementation_->lease.session == 0 ? 0 : implementation_->lease.fence;
}

const ServerCounters& ProtocolServer::counters() const { return implementation_->counters; }

}  // namespace hapticd
