// The server's side of the protocol (proto/PROTOCOL.md) as a pure state machine: datagrams and the
// time come in, datagrams go out through a callback. It owns sessions, the lease, subscriptions,
// the order of requests, pacing and repeating; what a request means for scene, loop and devices is
// its host's. No socket, no clock, no thread. One thread calls everything; callbacks of the host
// are called from inside receive() and poll() and may call answer(), broadcast() and offer_tick()
// at once. Times are ns of one monotonic clock, never going back. Not RT.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "hapticd/v1/stream.pb.h"
#include "server/network/address.h"
#include "server/network/encoded_states.h"
#include "server/network/lease.h"
#include "server/network/request_queue.h"
#include "server/network/server_host.h"
#include "server/network/sessions.h"

namespace hapticd {

/// The server. See the head of this file for how it is called.
class ProtocolServer {
 public:
  /// Sends one datagram; may lose it. The bytes live only during the call.
  using Send = Sessions::Send;

  ProtocolServer(const ServerOptions& options, ServerHost host, Send send);
  ~ProtocolServer() = default;
  ProtocolServer(const ProtocolServer&) = delete;
  ProtocolServer& operator=(const ProtocolServer&) = delete;

  /// One datagram as it came from the socket. Anything may be in it. Sends nothing but a Reset:
  /// call poll() when the socket is empty.
  void receive(const Address& from, std::span<const std::uint8_t> datagram, std::int64_t now_ns);
  /// What the socket has lost so far: datagrams that the system did not take, and those that came
  /// while its buffer was full. For GetCounts.
  void note_losses(std::uint64_t unsent, std::uint64_t overflowed) {
    sessions_.counters().unsent = unsent;
    sessions_.counters().overflowed = overflowed;
  }
  /// What the other road for Stop has brought so far. For GetCounts.
  void note_stop_road(const StopCounters& counters) { sessions_.counters().stop = counters; }
  /// Sends what is due, drops what is over. At least every 500 us, and after every batch of
  /// receive(), answer(), broadcast().
  void poll(std::int64_t now_ns);

  /// An event, SceneInfo or RecordInfo for every session; leaves with the next poll().
  void broadcast(const v1::Item& item);
  /// The result of a request; item_id is filled in here. Ignored when its session has ended or it
  /// has been answered already.
  void answer(const RequestId& id, v1::Result result);
  /// There is no memory to answer a request: its session ends without a word.
  void fall(const RequestId& id);
  /// Tick `tick` of scene `scene_id` is done: who is due gets its State now. Every tick is offered,
  /// in order; skipped ones only where the loop skipped or the network thread was late.
  void offer_tick(std::uint64_t tick, std::uint32_t scene_id, std::int64_t now_ns);
  /// Whether virtual time may take its next tick as far as the sessions are concerned. False while
  /// the session of a Run of steps is 64 States behind what it has reported as received, or has
  /// more than 256 Items to acknowledge; and while another session has, and still acknowledges
  /// (item_flow.h). For ticks that follow no clock: a clock waits for no session.
  [[nodiscard]] bool may_step(std::int64_t now_ns);

  /// Others take the place of ServerOptions::keys, which there are: sessions of a key that is gone
  /// end and are told why.
  void replace_keys(const noise::ServerKeys& keys, std::int64_t now_ns);

  /// The last Item of every session is Bye from now on; new sessions are ignored. Keep calling
  /// receive() and poll() until session_count() is 0: 1 s at most.
  void shut_down(v1::ByeReason reason, const std::string& message, std::int64_t now_ns);

  /// Sessions that live or say goodbye.
  [[nodiscard]] std::size_t session_count() const { return sessions_.all().size(); }
  /// Name of the holder of the lease; empty when nobody holds it or gave no name.
  [[nodiscard]] const std::string& lease_holder() const { return lease_.holder(); }
  /// Fencing number of the lease; 0 when nobody holds it.
  [[nodiscard]] std::uint64_t fence() const { return lease_.fence(); }
  [[nodiscard]] const ServerCounters& counters() const { return sessions_.counters(); }

 private:
  void tell_host(const Session& session, bool begins);
  void greet(Session& session);
  void take(Session& session, wire::Incoming& incoming);
  void note_scene(const v1::Item& item);
  void send_state(Session& session, std::uint64_t tick, std::uint32_t scene_id);

  ServerHost host_;
  bool virtual_clock_;
  std::uint64_t sounding_round_;  ///< ticks in which all that sounds is told again
  Sessions sessions_;
  Lease lease_;
  RequestQueue requests_;
  std::vector<double> rest_radii_m_;  ///< of the strings, from the newest SceneInfo
  EncodedStates encoded_states_;      ///< of the tick that was offered last
};

}  // namespace hapticd
