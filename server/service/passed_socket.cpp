// See passed_socket.h.
#include "server/service/passed_socket.h"

#include <sys/socket.h>
#include <systemd/sd-daemon.h>

#include <stdexcept>
#include <string>
#include <system_error>

namespace hapticd {
namespace {

[[noreturn]] void refuse(const std::string& what) {
  throw std::runtime_error("the socket passed by systemd: " + what +
                           ". Give the .socket unit one ListenDatagram=ADDR:PORT.");
}

}  // namespace

std::optional<int> passed_socket() {
  const int count = sd_listen_fds(1);
  if (count < 0) refuse(std::generic_category().message(-count));
  if (count == 0) return std::nullopt;
  if (count > 1) refuse(std::to_string(count) + " were passed, one is wanted");
  const int descriptor = SD_LISTEN_FDS_START;
  const int family = sd_is_socket(descriptor, AF_UNSPEC, 0, -1);
  if (family <= 0) refuse("it is no socket");
  if (sd_is_socket(descriptor, AF_UNSPEC, SOCK_DGRAM, -1) <= 0) refuse("it is not for datagrams");
  const bool internet = sd_is_socket_inet(descriptor, AF_UNSPEC, SOCK_DGRAM, -1, 0) > 0;
  if (!internet) refuse("it is not for IPv4 or IPv6");
  return descriptor;
}

}  // namespace hapticd
