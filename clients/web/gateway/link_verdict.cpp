// See link_verdict.h.
#include "clients/web/gateway/link_verdict.h"

#include <algorithm>
#include <array>
#include <cerrno>

namespace hapticd::web {
namespace {

/// What the system says when it has no way to an address.
constexpr std::array kNoWay{ENETUNREACH, EHOSTUNREACH, ENETDOWN, EADDRNOTAVAIL, EACCES, EPERM};

bool is_recent(std::int64_t then_ns, std::int64_t now_ns, std::int64_t span_ns) {
  return then_ns != 0 && now_ns - then_ns <= span_ns;
}

LinkVerdict no_route(const LinkFacts& facts) {
  if (facts.unknown_name) {
    return {v1::PAGE_LINK_STATE_NO_ROUTE, "there is no machine called " + facts.server + " (" +
                                              facts.trouble_text + "). Check --server"};
  }
  return {v1::PAGE_LINK_STATE_NO_ROUTE, "no route to " + facts.server + " (" + facts.trouble_text +
                                            "). Check the network of this machine, and --server"};
}

LinkVerdict gone(const LinkFacts& facts) {
  std::string message = "no daemon at " + facts.server;
  if (facts.said_bye) {
    message += ": it said goodbye";
    if (!facts.bye_message.empty()) message += " (" + facts.bye_message + ")";
  }
  return {v1::PAGE_LINK_STATE_DAEMON_GONE, message + ". Start hapticd; this comes back by itself"};
}

LinkVerdict unanswered(const LinkFacts& facts) {
  const std::string what = facts.keyed
                               ? "does not answer this key. Take view.key or control.key of the "
                                 "folder that hapticd --keys was given"
                               : "does not answer without a key. If hapticd runs with --keys, give "
                                 "one of them with --key";
  return {v1::PAGE_LINK_STATE_WRONG_KEY,
          facts.server + " " + what + "; or a firewall drops UDP on the way"};
}

LinkVerdict silent(const LinkFacts& facts, std::int64_t now_ns) {
  const std::int64_t seconds = (now_ns - facts.heard_ns) / 1'000'000'000;
  return {v1::PAGE_LINK_STATE_SILENT,
          "nothing has come from " + facts.server + " for " + std::to_string(seconds) +
              " s. Check the network in between, and whether hapticd is stuck"};
}

}  // namespace

LinkVerdict judge(const LinkFacts& facts, std::int64_t now_ns) {
  if (is_recent(facts.other_major_ns, now_ns, kLinkPatience_ns) &&
      facts.other_major_ns > facts.heard_ns) {
    return {v1::PAGE_LINK_STATE_VERSION_MISMATCH,
            facts.server + " speaks wire major " + std::to_string(facts.other_major) +
                ", this haptic-web speaks 1. Install both from the same release"};
  }
  const bool heard_lately = is_recent(facts.heard_ns, now_ns, kLinkSilence_ns);
  if (facts.full && heard_lately) {
    return {v1::PAGE_LINK_STATE_CONNECTING,
            facts.server +
                " has 32 clients, or 24 that may only look, and takes no more. End one of them"};
  }
  if (heard_lately && !facts.said_bye) return {v1::PAGE_LINK_STATE_LIVE, ""};
  if (is_recent(facts.trouble_ns, now_ns, kTroubleHolds_ns)) {
    const bool no_way = std::find(kNoWay.begin(), kNoWay.end(), facts.trouble) != kNoWay.end();
    if (no_way || facts.unknown_name) return no_route(facts);
    if (facts.trouble == ECONNREFUSED) return gone(facts);
  }
  if (facts.said_bye) return gone(facts);
  if (facts.heard_ns != 0) return silent(facts, now_ns);
  if (now_ns - facts.began_ns < kLinkPatience_ns) {
    return {v1::PAGE_LINK_STATE_CONNECTING, "asking " + facts.server};
  }
  return unanswered(facts);
}

}  // namespace hapticd::web
