// See protocol_server.h.
#include "server/network/protocol_server.h"

#include <algorithm>
#include <memory>
#include <utility>

namespace hapticd {

ProtocolServer::ProtocolServer(const ServerOptions& options, ServerHost host, Send send)
    : host_(std::move(host)),
      virtual_clock_(options.virtual_clock),
      sounding_round_(static_cast<std::uint64_t>(
          std::max<std::int64_t>(kSoundingPeriod_ns / options.period_ns, 1))),
      sessions_(options, std::move(send),
                {[this](Session& session) {
                   tell_host(session, true);
                   greet(session);
                 },
                 [this](Session& session) {
                   tell_host(session, false);
                   requests_.abandon(session);
                   lease_.give_up(session, LeaseEnd::kSessionEnded);
                 }}),
      lease_(sessions_, host_),
      requests_(sessions_, lease_, host_, options.work_time) {}

void ProtocolServer::greet(Session& session) {
  bool first = true;
  for (const v1::Item& item : host_.greeting()) {
    note_scene(item);
    sessions_.tell(session, item);
    if (!std::exchange(first, false)) continue;
    v1::Item lease_item;
    *lease_item.mutable_lease_info() = lease_.info(session);
    sessions_.tell(session, lease_item);
  }
}

void ProtocolServer::tell_host(const Session& session, bool begins) {
  if (!host_.session || !session.key_id.has_value()) return;
  // A session may end for want of memory.
  within_memory([&] {
    host_.session({begins, session.serial, session.address, session.role == wire::Role::kControl,
                   session.key_name});
  });
}

void ProtocolServer::note_scene(const v1::Item& item) {
  if (!item.has_scene_info()) return;
  std::vector<double> radii_m;
  for (const v1::String& string : item.scene_info().scene().strings()) {
    radii_m.push_back(string.radius_m());
  }
  rest_radii_m_ = std::move(radii_m);
}

void ProtocolServer::receive(const Address& from, std::span<const std::uint8_t> datagram,
                             std::int64_t now_ns) {
  sessions_.set_time(now_ns);
  const bool done = within_memory([&] {
    std::optional<ArrivedPacket> arrived = sessions_.receive(from, datagram);
    if (arrived) take(*arrived->session, arrived->incoming);
  });
  // What of it was taken is acknowledged, and what was not is not repeated.
  if (!done) sessions_.fall(from, datagram);
}

void ProtocolServer::take(Session& session, wire::Incoming& incoming) {
  lease_.renew(session);
  const v1::Packet& packet = incoming.packet;
  if (packet.has_clock()) session.clock.take(packet.clock(), sessions_.now_ns());
  if (incoming.newest) {
    session.flow.told(packet.seen(), packet.newest(), !virtual_clock_, sessions_.now_ns());
  }
  for (wire::ReceivedItem& received : incoming.items.items) {
    if (session.phase != Phase::kOpen) return;
    requests_.take(session, received);
  }
  if (incoming.items.broken != nullptr && session.phase == Phase::kOpen) {
    ++sessions_.counters().protocol_errors;
    sessions_.close(session, v1::BYE_REASON_PROTOCOL_ERROR, incoming.items.broken);
  }
}

void ProtocolServer::poll(std::int64_t now_ns) {
  sessions_.set_time(now_ns);
  lease_.expire();
  requests_.serve_costly();
  sessions_.poll();
}

void ProtocolServer::broadcast(const v1::Item& item) {
  note_scene(item);
  sessions_.tell_all(item);
}

void ProtocolServer::answer(const RequestId& id, v1::Result result) {
  requests_.answer(id, std::move(result));
}

void ProtocolServer::fall(const RequestId& id) {
  Session* session = sessions_.find(id.session);
  if (session != nullptr) sessions_.fall(*session);
}

void ProtocolServer::offer_tick(std::uint64_t tick, std::uint32_t scene_id, std::int64_t now_ns) {
  sessions_.set_time(now_ns);
  encoded_states_.begin(tick, scene_id);
  for (const auto& pointer : sessions_.all()) {
    Session& session = *pointer;
    if (session.phase != Phase::kOpen ||
        !session.flow.wants(tick, now_ns - session.heard_ns, now_ns)) {
      continue;
    }
    const bool told = within_memory([&] { send_state(session, tick, scene_id); });
    // Lockstep leaves none out.
    if (!told && virtual_clock_) sessions_.fall(session);
  }
}

void ProtocolServer::send_state(Session& session, std::uint64_t tick, std::uint32_t scene_id) {
  std::shared_ptr<const EncodedState> state =
      encoded_states_.get(session.flow.asked_at(tick, scene_id, sounding_round_),
                          sessions_.state_bytes(session), host_.fill_state, rest_radii_m_);
  sessions_.counters().unfit_states += state->unfit;
  session.flow.left_out(state->soundings_from);
  session.flow.sent(tick, scene_id, state->parts.size(), sessions_.now_ns());
  sessions_.send_states(session, *state);
  if (virtual_clock_) session.newest_state = std::move(state);
}

bool ProtocolServer::may_step(std::int64_t now_ns) {
  bool may = true;
  for (const auto& session : sessions_.all()) {
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

void ProtocolServer::replace_keys(const noise::ServerKeys& keys, std::int64_t now_ns) {
  sessions_.set_time(now_ns);
  sessions_.replace_keys(keys);
}

void ProtocolServer::shut_down(v1::ByeReason reason, const std::string& message,
                               std::int64_t now_ns) {
  sessions_.set_time(now_ns);
  sessions_.shut_down(reason, message);
}

}  // namespace hapticd
