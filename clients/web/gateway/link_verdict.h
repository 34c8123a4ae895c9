// The state of the link to the daemon, worded so that a person can fix it: from what was heard, and
// from what the system said about what was sent. A daemon does not answer without its key, and
// ignores other wire majors, so some of it is inferred: a machine where nothing listens says so
// (ICMP), one that stays quiet has something that listens and does not answer. Pure. Not RT.
#pragma once

#include <cstdint>
#include <string>

#include "hapticd/v1/gateway.pb.h"

namespace hapticd::web {

/// Silence after which a link is not live any more, ns: ten keep-alives.
inline constexpr std::int64_t kLinkSilence_ns = 1'000'000'000;
/// Time that a daemon gets to answer at first, ns: a handshake is repeated every 250 ms.
inline constexpr std::int64_t kLinkPatience_ns = 2'000'000'000;
/// How long what the system said about a datagram holds, ns: it says so again for each that leaves.
inline constexpr std::int64_t kTroubleHolds_ns = 1'500'000'000;

/// What is known of a link. Instants are ns of one clock; 0 = never.
struct LinkFacts {
  std::string server;           ///< as given
  bool keyed = false;           ///< a key was given
  std::int64_t began_ns = 0;    ///< when the first datagram left
  std::int64_t heard_ns = 0;    ///< last valid datagram, in whichever session
  int trouble = 0;              ///< errno of sending or receiving
  std::int64_t trouble_ns = 0;  ///< when it was
  std::string trouble_text;     ///< the system's words, or the resolver's
  bool unknown_name = false;    ///< the name of the server could not be resolved
  int other_major = 0;          ///< wire major of datagrams that are not ours; 0 = none came
  std::int64_t other_major_ns = 0;
  bool full = false;        ///< its last word was that 32 sessions are open
  bool said_bye = false;    ///< its last word was Bye
  std::string bye_message;  ///< with this message
};

/// State and words of it, for a PageLink.
struct LinkVerdict {
  v1::PageLinkState state = v1::PAGE_LINK_STATE_CONNECTING;
  std::string message;

  friend bool operator==(const LinkVerdict&, const LinkVerdict&) = default;
};

/// The state of a link with these facts at `now_ns`.
[[nodiscard]] LinkVerdict judge(const LinkFacts& facts, std::int64_t now_ns);

}  // namespace hapticd::web
