// See endpoint.h.
#include "clients/library/endpoint.h"

#include <charconv>
#include <stdexcept>

namespace hapticd::client {
namespace {

/// Whether `host` may be a name or an address: of a URL it is neither. Whether it exists is not
/// known here.
bool may_be_host(const std::string& host) {
  if (host.find_first_of("/@?# \t") != std::string::npos) return false;
  // More than one colon is an IPv6 address, which may have its interface behind a %.
  return host.find(':') == std::string::npos ||
         host.substr(0, host.find('%')).find_first_not_of("0123456789abcdefABCDEF:.") ==
             std::string::npos;
}

}  // namespace

Endpoint parse_endpoint(const std::string& text, Endpoint otherwise, bool zero_port) {
  const auto bad = [&] {
    return std::invalid_argument(
        "'" + text + "' is not HOST, HOST:PORT or [V6]:PORT; a port is a number up to 65535");
  };
  std::string port;
  if (text.starts_with('[')) {
    const std::size_t end = text.find(']');
    if (end == std::string::npos) throw bad();
    otherwise.host = text.substr(1, end - 1);
    port = text.substr(end + 1);
  } else {
    const std::size_t colon = text.find(':');
    // More than one colon is an IPv6 address without a port.
    const bool alone = colon != text.rfind(':');
    const std::string host = alone ? text : text.substr(0, colon);
    if (!host.empty()) otherwise.host = host;
    if (!alone && colon != std::string::npos) port = text.substr(colon);
  }
  if (!may_be_host(otherwise.host)) throw bad();
  if (port.empty()) return otherwise;
  int number = 0;
  const char* end = port.data() + port.size();
  const auto read = std::from_chars(port.data() + 1, end, number);
  if (port[0] != ':' || read.ptr != end || read.ec != std::errc{} || number < (zero_port ? 0 : 1) ||
      number > 65535) {
    throw bad();
  }
  otherwise.port = static_cast<std::uint16_t>(number);
  return otherwise;
}

}  // namespace hapticd::client
