// See http_connection.h.
#include "clients/web/gateway/http_connection.h"

#include <boost/beast/core/flat_buffer.hpp>
#include <boost/beast/http/empty_body.hpp>
#include <boost/beast/http/parser.hpp>
#include <boost/beast/http/read.hpp>
#include <boost/beast/http/string_body.hpp>
#include <boost/beast/http/write.hpp>
#include <boost/beast/websocket/rfc6455.hpp>
#include <chrono>
#include <string_view>
#include <utility>

#include "clients/library/client.h"
#include "clients/web/gateway/access.h"
#include "clients/web/gateway/page_folder.h"
#include "clients/web/gateway/viewer.h"

// NOLINTBEGIN(misc-no-recursion): handlers that begin the next step look like recursion.
namespace hapticd::web {

namespace http = boost::beast::http;
using boost::system::error_code;
using Shared = HttpServer::Shared;

namespace {

/// Time for a TLS handshake, a request, an answer.
constexpr std::chrono::seconds kPatience{10};
constexpr std::uint32_t kMaxHeadBytes = 8192;
constexpr std::string_view kAssetPath = "/asset/";

std::string_view view_of(boost::beast::string_view text) { return {text.data(), text.size()}; }

class Connection : public std::enable_shared_from_this<Connection> {
 public:
  Connection(std::shared_ptr<Shared> shared, boost::asio::ip::tcp::socket socket)
      : shared_(std::move(shared)),
        stream_(std::in_place, std::move(socket),
                shared_->tls.has_value() ? &*shared_->tls : nullptr) {
    ++shared_->connections;
  }
  ~Connection() {
    if (stream_.has_value()) --shared_->connections;
  }
  Connection(const Connection&) = delete;
  Connection& operator=(const Connection&) = delete;

  void begin() {
    if (stream_->tls() == nullptr) return read();
    stream_->next_layer().expires_after(kPatience);
    stream_->tls()->async_handshake(boost::asio::ssl::stream_base::server,
                                    [self = shared_from_this()](const error_code& error) {
                                      if (!error) self->read();
                                    });
  }

 private:
  using Answer = http::response<http::string_body>;

  void read();
  void handle();
  void handshake();
  void join(bool control, const std::string& subprotocol);
  Answer answer_to(std::string_view target) const;
  Answer made(http::status status, const std::string& type, std::string body) const;
  void send(Answer answer);
  [[nodiscard]] bool is_from_here() const;

  std::shared_ptr<Shared> shared_;
  std::optional<PageStream> stream_;  ///< empty once it is a viewer's
  boost::beast::flat_buffer buffer_;
  std::optional<http::request_parser<http::empty_body>> parser_;
  std::shared_ptr<http::response<http::string_body>> answer_;
};

void Connection::read() {
  parser_.emplace();
  parser_->header_limit(kMaxHeadBytes);
  parser_->body_limit(std::uint64_t{0});
  stream_->next_layer().expires_after(kPatience);
  http::async_read(*stream_, buffer_, *parser_,
                   [self = shared_from_this()](const error_code& error, std::size_t) {
                     if (!error) self->handle();
                   });
}

void Connection::handle() {
  ++shared_->counters.requests;
  const auto& request = parser_->get();
  const std::string target(view_of(request.target()));
  if (!is_own_host(view_of(request[http::field::host]), shared_->options.names)) {
    ++shared_->counters.refused_origin;
    return send(made(http::status::misdirected_request, "text/plain",
                     "haptic-web does not go by this name. Start it with --name, or use "
                     "its address.\n"));
  }
  if (boost::beast::websocket::is_upgrade(request)) {
    if (target == "/stream") return handshake();
    return send(made(http::status::not_found, "text/plain", "the stream is at /stream\n"));
  }
  if (request.method() != http::verb::get && request.method() != http::verb::head) {
    return send(made(http::status::method_not_allowed, "text/plain", "only GET and HEAD\n"));
  }
  send(answer_to(target));
}

Connection::Answer Connection::made(http::status status, const std::string& type,
                                    std::string body) const {
  Answer answer(status, parser_->get().version());
  answer.set(http::field::content_type, type);
  answer.set(http::field::cache_control, "no-cache");
  answer.set("X-Content-Type-Options", "nosniff");
  answer.set("X-Frame-Options", "DENY");
  answer.set("Cross-Origin-Resource-Policy", "same-origin");
  // The token is behind the # of the address: browsers never send that, nor may the rest go.
  answer.set("Referrer-Policy", "no-referrer");
  answer.body() = std::move(body);
  answer.keep_alive(parser_->get().keep_alive());
  return answer;
}

Connection::Answer Connection::answer_to(std::string_view target) const {
  const auto lasting = [](Answer answer) {
    answer.set(http::field::cache_control, "public, max-age=31536000, immutable");
    return answer;
  };
  if (target.starts_with(kAssetPath)) {
    auto bytes = shared_->options.asset
                     ? shared_->options.asset(std::string(target.substr(kAssetPath.size())))
                     : std::nullopt;
    if (bytes.has_value()) {
      return lasting(made(http::status::ok, "application/octet-stream", std::move(*bytes)));
    }
    return made(http::status::not_found, "text/plain",
                "no file has this hash. Name the folder of the scene's models with --assets\n");
  }
  if (target == "/metrics" && shared_->options.metrics) {
    return made(http::status::ok, "text/plain; version=0.0.4; charset=utf-8",
                shared_->options.metrics());
  }
  auto file = page_file(shared_->options.page, target);
  if (file.has_value()) {
    Answer answer = made(http::status::ok, file->type, std::move(file->bytes));
    return file->lasting ? lasting(std::move(answer)) : answer;
  }
  if (target == "/") {
    return made(http::status::not_found, "text/plain",
                "there is no page in " + shared_->options.page.string() +
                    ". Name its folder with --page\n");
  }
  return made(http::status::not_found, "text/plain", "there is no such file\n");
}

void Connection::send(Answer answer) {
  answer_ = std::make_shared<Answer>(std::move(answer));
  answer_->prepare_payload();
  // HEAD wants the head of what GET would get.
  if (parser_->get().method() == http::verb::head) answer_->body().clear();
  stream_->next_layer().expires_after(kPatience);
  http::async_write(*stream_, *answer_,
                    [self = shared_from_this()](const error_code& error, std::size_t) {
                      if (!error && self->answer_->keep_alive()) self->read();
                    });
}

bool Connection::is_from_here() const {
  error_code unknown;
  const auto remote = stream_->next_layer().socket().remote_endpoint(unknown);
  if (unknown) return false;
  const auto address = remote.address();
  if (address.is_v6() && address.to_v6().is_v4_mapped()) {
    return boost::asio::ip::make_address_v4(boost::asio::ip::v4_mapped, address.to_v6())
        .is_loopback();
  }
  return address.is_loopback();
}

void Connection::handshake() {
  const auto& request = parser_->get();
  const bool tls = stream_->tls() != nullptr;
  if (!may_look(view_of(request[http::field::origin]), view_of(request[http::field::host]), tls,
                shared_->options.names)) {
    ++shared_->counters.refused_origin;
    return send(made(http::status::forbidden, "text/plain", "not for pages from elsewhere\n"));
  }
  if (shared_->viewers >= shared_->options.most_viewers) {
    ++shared_->counters.refused_full;
    return send(made(http::status::service_unavailable, "text/plain",
                     "no place is left: --viewers limits their number\n"));
  }
  const std::string subprotocol =
      own_subprotocol(view_of(request[http::field::sec_websocket_protocol]));
  const bool good = carries_token(subprotocol, shared_->options.token);
  if (!good && subprotocol.size() > kSubprotocol.size()) ++shared_->counters.bad_tokens;
  join(good && (tls || is_from_here()), subprotocol);
}

void Connection::join(bool control, const std::string& subprotocol) {
  ++shared_->viewers;
  auto closed = [shared = shared_] {
    --shared->viewers;
    --shared->connections;
  };
  const auto viewer =
      std::make_shared<Viewer>(std::move(*stream_), shared_->hub, control, std::move(closed));
  stream_.reset();
  viewer->accept(parser_->release(), subprotocol);
}

}  // namespace

void begin_connection(const std::shared_ptr<Shared>& shared, boost::asio::ip::tcp::socket socket) {
  std::make_shared<Connection>(shared, std::move(socket))->begin();
}

}  // namespace hapticd::web
// NOLINTEND(misc-no-recursion)
