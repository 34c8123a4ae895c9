// See session_log.h.
#include "server/daemon/session_log.h"

#include <arpa/inet.h>
#include <spdlog/spdlog.h>

#include <array>

namespace hapticd {
namespace {

std::string text_of(const Address& address) {
  std::array<char, INET6_ADDRSTRLEN> text{};
  const bool v4 = is_ipv4(address);
  const void* bytes = v4 ? address.ip.data() + 12 : address.ip.data();
  if (::inet_ntop(v4 ? AF_INET : AF_INET6, bytes, text.data(), text.size()) == nullptr) return {};
  const std::string ip = text.data();
  return (v4 ? ip : "[" + ip + "]") + ":" + std::to_string(address.port);
}

}  // namespace

std::string who_is(const SessionNotice& notice) {
  const std::string role = notice.may_control ? "control" : "view";
  const std::string key =
      notice.key_name.empty() ? role + ".key" : "key " + notice.key_name + " (" + role + ")";
  return key + " at " + text_of(notice.address);
}

void log_session(const SessionNotice& notice) {
  spdlog::info("session {} {}: {}", notice.serial, notice.begins ? "opened" : "ended",
               who_is(notice));
}

}  // namespace hapticd
