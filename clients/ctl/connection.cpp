// See connection.h.
#include "clients/ctl/connection.h"

#include <utility>

#include "clients/ctl/text.h"
#include "clients/library/named_key.h"
#include "proto/wire/shown_text.h"

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
  try {
    return client::named_key(options.daemon.key_file, options.daemon.role);
  } catch (const std::runtime_error& error) {
    throw Failure(kRefused, std::string("--key: ") + error.what());
  }
}

}  // namespace

client::Endpoint server_of(const GlobalOptions& options) {
  try {
    return client::parse_endpoint(options.daemon.server);
  } catch (const std::invalid_argument& error) {
    throw Failure(kUsageBad, std::string("--server: ") + error.what());
  }
}

std::chrono::nanoseconds timeout_of(const GlobalOptions& options) {
  return std::chrono::nanoseconds(static_cast<std::int64_t>(options.timeout_s * 1e9));
}

std::unique_ptr<client::Client> connect(const GlobalOptions& options,
                                        client::ClientHandlers handlers) {
  const client::Endpoint server = server_of(options);
  const std::optional<client::ClientKey> key = key_of(options);
  std::unique_ptr<client::Client> made;
  try {
    made = std::make_unique<client::Client>(server.host, server.port, std::move(handlers), key);
  } catch (const std::runtime_error& error) {
    throw Failure(kUnreachable, error.what());
  }
  if (!made->connect(timeout_of(options))) {
    const std::string& refusal = made->core().refusal();
    if (!refusal.empty()) {
      throw Failure(kUnreachable,
                    "the daemon at " + made->server() + " refuses: " + wire::shown_text(refusal));
    }
    throw Failure(kUnreachable, unreachable(made->server(), key.has_value()));
  }
  return made;
}

void require(const v1::Result& result) {
  if (result.code() == v1::RESULT_CODE_OK) return;
  if (result.code() == v1::RESULT_CODE_UNSPECIFIED) throw Failure(kUnreachable, result.message());
  std::string code = v1::ResultCode_Name(result.code());
  // That of a later version has no name here.
  if (code.empty()) code = std::to_string(result.code());
  constexpr std::string_view kPrefix = "RESULT_CODE_";
  if (code.starts_with(kPrefix)) code.erase(0, kPrefix.size());
  std::string text = "refused (" + code + ")";
  // What is wrong with a text names its fields itself.
  const bool named = result.message().find(result.path() + ": ") != std::string::npos;
  if (!result.path().empty() && !named) text += " " + wire::shown_text(result.path());
  if (!result.message().empty()) text += ": " + result.message();
  throw Refusal(result, text);
}

v1::Result ask(client::Client& client, const v1::Item& item, const GlobalOptions& options) {
  require_utf8(item);
  v1::Result result = client.call(item, timeout_of(options));
  require(result);
  return result;
}

void refuse_json(const GlobalOptions& options, const std::string& why) {
  if (options.json) throw Failure(kUsageBad, "--json has no meaning here: " + why);
}

void acquire(client::Controller& controller, const client::Client& client,
             const GlobalOptions& options) {
  const v1::Result result = options.take_over.empty()
                                ? controller.acquire(kHolder)
                                : controller.take_over(kHolder, options.take_over);
  if (result.code() == v1::RESULT_CODE_BUSY) {
    const std::string holder = wire::shown_text(client.lease().holder());
    throw Refusal(result,
                  "another session controls the daemon" +
                      (holder.empty() ? std::string() : " (" + holder + ")") +
                      ". Wait until it lets go, its lease ends 2 s after it falls silent; or take "
                      "it over, with --take-over REASON");
  }
  require(result);
}

v1::Result control(client::Client& client, const v1::Item& item, const GlobalOptions& options) {
  require_utf8(item);
  client::Controller controller(client);
  acquire(controller, client, options);
  v1::Result result = controller.call(item, timeout_of(options));
  controller.release();
  require(result);
  return result;
}

}  // namespace hapticd::ctl
