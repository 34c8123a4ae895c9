// See connection.h.
#include "clients/ctl/connection.h"

#include <charconv>
#include <utility>

namespace hapticd::ctl {
namespace {

/// How hapticctl calls itself when it holds the lease.
constexpr const char* kHolder = "hapticctl";

std::string unreachable(const std::string& server, bool keyed) {
  const std::string keys = keyed ? "the key of --key may not be one of its keys"
                                 : "if it has keys, give one of them with --key FILE";
  return "no daemon answers at " + server +
         ". Start hapticd, or name where it listens with --server ADDR:PORT; " + keys;
}

std::optional<client::ClientKey> key_of(const GlobalOptions& options) {
  if (options.key_file.empty()) return std::nullopt;
  std::optional<wire::Role> role;
  if (options.role == "view") role = wire::Role::kView;
  if (options.role == "control") role = wire::Role::kControl;
  try {
    return client::read_client_key(options.key_file, role);
  } catch (const std::runtime_error& error) {
    throw Failure(kRefused, std::string("--key: ") + error.what());
  }
}

}  // namespace

Endpoint parse_endpoint(const std::string& text) {
  const auto bad = [&]() -> Failure {
    return {kUsageBad, "--server: '" + text + "' is not HOST, HOST:PORT or [V6]:PORT"};
  };
  Endpoint endpoint;
  std::string port;
  if (text.starts_with('[')) {
    const std::size_t end = text.find(']');
    if (end == std::string::npos) throw bad();
    endpoint.host = text.substr(1, end - 1);
    port = text.substr(end + 1);
  } else {
    const std::size_t colon = text.find(':');
    // More than one colon is an IPv6 address without a port.
    const bool alone = colon != text.rfind(':');
    endpoint.host = alone ? text : text.substr(0, colon);
    port = alone || colon == std::string::npos ? "" : text.substr(colon);
  }
  if (endpoint.host.empty()) endpoint.host = "127.0.0.1";
  if (port.empty()) return endpoint;
  int number = 0;
  const char* end = port.data() + port.size();
  const auto read = std::from_chars(port.data() + 1, end, number);
  if (port[0] != ':' || read.ptr != end || read.ec != std::errc{} || number < 1 || number > 65535) {
    throw bad();
  }
  endpoint.port = static_cast<std::uint16_t>(number);
  return endpoint;
}

std::chrono::nanoseconds timeout_of(const GlobalOptions& options) {
  return std::chrono::nanoseconds(static_cast<std::int64_t>(options.timeout_s * 1e9));
}

std::unique_ptr<client::Client> connect(const GlobalOptions& options,
                                        client::ClientHandlers handlers) {
  const Endpoint endpoint = parse_endpoint(options.server);
  const std::optional<client::ClientKey> key = key_of(options);
  std::unique_ptr<client::Client> made;
  try {
    made = std::make_unique<client::Client>(endpoint.host, endpoint.port, std::move(handlers), key);
  } catch (const std::runtime_error& error) {
    throw Failure(kUnreachable, error.what());
  }
  if (!made->connect(timeout_of(options))) {
    throw Failure(kUnreachable, unreachable(made->server(), key.has_value()));
  }
  return made;
}

void require(const v1::Result& result) {
  if (result.code() == v1::RESULT_CODE_OK) return;
  if (result.code() == v1::RESULT_CODE_UNSPECIFIED) throw Failure(kUnreachable, result.message());
  // RESULT_CODE_NOT_FOUND without what all have in common.
  const std::string code = v1::ResultCode_Name(result.code()).substr(12);
  std::string text = "refused (" + code + ")";
  if (!result.path().empty()) text += " " + result.path();
  if (!result.message().empty()) text += ": " + result.message();
  throw Failure(kRefused, text);
}

v1::Result ask(client::Client& client, const v1::Item& item, const GlobalOptions& options) {
  v1::Result result = client.call(item, timeout_of(options));
  require(result);
  return result;
}

void acquire(client::Controller& controller, const client::Client& client) {
  const v1::Result result = controller.acquire(kHolder);
  if (result.code() == v1::RESULT_CODE_BUSY) {
    const std::string& holder = client.lease().holder();
    throw Failure(kRefused,
                  "another session controls the daemon" +
                      (holder.empty() ? std::string() : " (" + holder + ")") +
                      ". Wait until it lets go; its lease ends 2 s after it falls silent");
  }
  require(result);
}

v1::Result control(client::Client& client, const v1::Item& item, const GlobalOptions& options) {
  client::Controller controller(client);
  acquire(controller, client);
  v1::Result result = controller.call(item, timeout_of(options));
  controller.release();
  require(result);
  return result;
}

}  // namespace hapticd::ctl
