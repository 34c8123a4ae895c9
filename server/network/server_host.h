// What server and daemon say to each other: requests and their names, subscriptions, how a lease
// ends, and what the server counts. Not RT.
#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "hapticd/v1/stream.pb.h"
#include "proto/noise/key_folder.h"
#include "proto/stop/stop_counters.h"
#include "proto/wire/item_outbox.h"
#include "server/network/address.h"
#include "server/network/handshakes.h"

namespace hapticd {

/// Names one request of one session for as long as the server runs.
struct RequestId {
  std::uint64_t session = 0;  ///< serial number of the session, from 1, never used again
  std::uint64_t item = 0;     ///< id of the request's Item, or of its last Chunk

  friend bool operator==(const RequestId&, const RequestId&) = default;
};

/// What States a session asked for.
struct Subscription {
  std::uint32_t divisor = 0;       ///< every this many ticks; 0 = none
  std::uint32_t sections = 0;      ///< bit s set: v1::Section s
  std::uint32_t max_contacts = 0;  ///< [0, 256]
  /// What sounds is repeated in this State, of strings with this index or a greater one; nothing:
  /// in this one it is not. Nobody asks for it: see StateFlow::asked_at().
  std::optional<std::uint32_t> soundings_from = std::nullopt;

  /// Whether `section` was asked for.
  [[nodiscard]] constexpr bool has(v1::Section section) const noexcept {
    return (sections >> static_cast<unsigned>(section) & 1U) != 0;
  }
  friend bool operator==(const Subscription&, const Subscription&) = default;
};

/// How a lease ended.
enum class LeaseEnd : std::uint8_t { kReleased, kSessionEnded, kExpired, kTakenOver };

/// A session with a key, as it begins and when it ends.
struct SessionNotice {
  bool begins = false;
  std::uint64_t serial = 0;  ///< as in RequestId
  Address address;           ///< of its client
  bool may_control = false;  ///< by its key
  std::string key_name;      ///< empty: view.key or control.key
};

/// What the server asks of the daemon. Every function must be set that is not said to be empty.
struct ServerHost {
  /// SceneInfo and RecordInfo for a session that begins, in this order; the server puts LeaseInfo
  /// between them. Called for nothing else: changes come through broadcast().
  std::function<std::vector<v1::Item>()> greeting;
  /// A request that is not the server's own, when its turn has come and lease and fence permit it.
  /// The host calls ProtocolServer::answer() once for it, at once or later. PoseBatch, too, is
  /// always answered; the server swallows its OK. Stop may come while an earlier request of the
  /// session is unanswered, and so may Run{STOP} during a Run of steps: the host then ends that Run
  /// at the next tick. A Replay of the same session waits for its turn like every other request.
  std::function<void(const RequestId&, const v1::Item&)> request;
  /// The session of a request that was passed on and not answered has ended, or a Run's has lost
  /// the lease to another. A Run of steps ends at
  /// the next tick; anything else may be finished. Its answer is not wanted any more, and ignored.
  std::function<void(const RequestId&)> abandoned;
  /// Fills in the sections of the tick offered last; at most subscription.max_contacts contacts,
  /// deepest first, contacts_total set when there were more. Called only inside offer_tick(), once
  /// for equal subscriptions: what it fills in may depend on nothing else.
  std::function<void(const Subscription&, v1::State&)> fill_state;
  /// Nobody holds the lease any more, or another holder: scripted poses end, the force ramps to
  /// zero.
  std::function<void(LeaseEnd)> lease_lost;
  /// Everyone is being told this of the lease, where `yours` means nothing; may be empty.
  std::function<void(const v1::LeaseInfo&)> lease_told = nullptr;
  /// A session with a key has begun or ended, for the log; may be empty.
  std::function<void(const SessionNotice&)> session = nullptr;
};

/// Fixed at construction.
struct ServerOptions {
  std::uint32_t boot_id = 1;   ///< random number of this run of the daemon, not 0
  bool virtual_clock = false;  ///< lockstep: no State is left out because of loss
  /// Only keyed sessions are served; nothing: only PLAIN ones.
  std::optional<noise::ServerKeys> keys = std::nullopt;
  /// Sessions begun by NNpsk0, as clients of 0.1 begin them, are served; else they are told why
  /// not.
  bool old_handshake = false;
  /// Fills bytes with random ones, fit for secrets; empty: those of the system. For keyed sessions.
  std::function<void(std::span<std::uint8_t>)> random = nullptr;
  std::int64_t period_ns = wire::kMillisecond_ns;  ///< of a tick, > 0
  /// Time in which requests are carried out, ns; empty: the system's monotonic clock. Others' is
  /// the one that receive() and poll() are told, which stands still meanwhile.
  std::function<std::int64_t()> work_time = nullptr;
};

/// What was received and not used, and why. Junk costs nothing else.
struct ServerCounters {
  std::uint64_t received = 0;
  std::uint64_t bad_header = 0;        ///< length, magic, major or kind (steps 1 and 2)
  std::uint64_t unknown_session = 0;   ///< step 3
  std::uint64_t repeated = 0;          ///< counter seen before or too old (step 4)
  std::uint64_t unreadable = 0;        ///< does not parse, first = 0, more than 16 Items (step 5)
  std::uint64_t forged = 0;            ///< the tag of a DATA does not verify (step 5)
  HelloCounters hellos;                ///< what became of them
  std::uint64_t full = 0;              ///< sessions that found no place
  std::uint64_t evicted = 0;           ///< sessions that gave their place to another
  std::uint64_t old_keys = 0;          ///< sessions refused: begun by a client of 0.1
  std::uint64_t revoked = 0;           ///< sessions ended because their key was revoked
  std::uint64_t protocol_errors = 0;   ///< sessions ended for breaking the rules
  std::uint64_t untold = 0;            ///< Items that were too long, and a notice took their place
  std::uint64_t backlogs = 0;          ///< sessions ended with 1024 Items unacknowledged
  std::uint64_t silences = 0;          ///< sessions dropped after 10 s
  std::uint64_t fallen = 0;            ///< sessions dropped for want of memory
  std::uint64_t resets = 0;            ///< Resets sent
  std::uint64_t resets_limited = 0;    ///< not sent: one left to the address a moment ago
  std::uint64_t requests_limited = 0;  ///< answered BUSY: too many of the session wait
  std::uint64_t sent = 0;              ///< datagrams sent
  std::uint64_t unsent = 0;            ///< datagrams that the system did not take
  std::uint64_t overflowed = 0;        ///< that came, and found no room in the system's buffer
  std::uint64_t unfit_states = 0;      ///< States of one tool that no datagram holds: not sent
  StopCounters stop;                   ///< what the other road for Stop has brought
};

}  // namespace hapticd
