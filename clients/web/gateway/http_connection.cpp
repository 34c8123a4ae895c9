// See http_connection.h.
#include "clients/web/gateway/http_connection.h"

#include <boost/asio/write.hpp>
#include <boost/beast/core/flat_buffer.hpp>
#include <boost/beast/http/empty_body.hpp>
#include <boost/beast/http/error.hpp>
#include <boost/beast/http/parser.hpp>
#include <boost/beast/http/read.hpp>
#include <boost/beast/http/string_body.hpp>
#include <boost/beast/http/write.hpp>
#include <boost/beast/websocket/rfc6455.hpp>
#include <chrono>
#include <sstream>
#include <string_view>
#include <utility>

#include "clients/library/client.h"
#include "clients/web/gateway/access.h"
#include "clients/web/gateway/answer_head.h"
#include "clients/web/gateway/viewer.h"

// NOLINTBEGIN(misc-no-recursion): handlers that begin the next step look like recursion.
namespace hapticd::web {

namespace http = boost::beast::http;
using boost::system::error_code;
using Shared = HttpServer::Shared;

namespace {

/// Time for a TLS handshake, a request, a short answer, a block of a long one.
constexpr std::chrono::seconds kPatience{10};
constexpr std::uint32_t kMaxHeadBytes = 8192;
constexpr std::string_view kAssetPath = "/asset/";
constexpr const char* kNoAsset =
    "no file has this hash. Name the folder of the scene's models with --assets\n";

std::string_view view_of(boost::beast::string_view text) { return {text.data(), text.size()}; }

/// Whether one of the tags of an If-None-Match is `tag`, quotes and all.
bool names(std::string_view if_none_match, const std::string& tag) {
  return if_none_match == "*" || if_none_match.find(tag) != std::string_view::npos;
}

class Connection : public std::enable_shared_from_this<Connection> {
 public:
  /// It has a place at the door.
  Connection(std::shared_ptr<Shared> shared, boost::asio::ip::tcp::socket socket,
             boost::asio::ip::address from)
      : address_(std::move(from)),
        shared_(std::move(shared)),
        stream_(std::in_place, std::move(socket),
                shared_->tls.has_value() ? &*shared_->tls : nullptr) {}
  ~Connection() {
    end_wait();
    if (stream_.has_value() && !gave_way_) shared_->door.leave(address_);
  }
  Connection(const Connection&) = delete;
  Connection& operator=(const Connection&) = delete;

  void begin() {
    if (stream_->tls() == nullptr) return read();
    begin_wait();
    stream_->tls()->async_handshake(boost::asio::ssl::stream_base::server,
                                    [self = shared_from_this()](const error_code& error) {
                                      if (!error && !self->gave_way_) self->read();
                                    });
  }

 private:
  using Answer = http::response<http::string_body>;

  void begin_wait();
  void end_wait() { shared_->door.resume(std::exchange(wait_, 0)); }
  void read();
  void refuse_garbage(const error_code& error);
  void handle();
  void handshake();
  bool find_place(bool token);
  void join(bool token, bool may, const std::string& subprotocol);
  void answer(const std::string& target);
  [[nodiscard]] Answer made(http::status status, const std::string& type, std::string body) const;
  void send(Answer answer);
  void found(std::optional<PageFile> file, const std::string& missing);
  [[nodiscard]] std::string head_of_file(http::status status) const;
  void send_block(std::size_t index);
  void write(std::string head, std::size_t next_block);
  [[nodiscard]] std::string_view field(http::field name) const {
    return view_of(parser_->get()[name]);
  }

  boost::asio::ip::address address_;
  std::uint64_t wait_ = 0;  ///< its number at the door; 0 = it does not wait
  std::shared_ptr<Shared> shared_;
  std::optional<PageStream> stream_;  ///< empty once it is a viewer's
  boost::beast::flat_buffer buffer_;
  std::optional<http::request_parser<http::empty_body>> parser_;
  std::shared_ptr<http::response<http::string_body>> answer_;
  std::optional<PageFile> file_;  ///< under way
  std::string outgoing_;          ///< of it
  bool gave_way_ = false;         ///< its place is another's
};

/// From here on it may have to give way, and has kPatience.
void Connection::begin_wait() {
  end_wait();
  wait_ = shared_->door.wait(address_, client::monotonic_now_ns(), [weak = weak_from_this()] {
    const auto self = weak.lock();
    error_code ignored;
    if (self == nullptr || !self->stream_) return;
    self->stream_->next_layer().socket().close(ignored);
    // Its place is free already: more may come before its end is noticed.
    self->gave_way_ = true;
  });
  stream_->next_layer().expires_after(kPatience);
}

void Connection::read() {
  begin_wait();
  parser_.emplace();
  parser_->header_limit(kMaxHeadBytes);
  parser_->body_limit(std::uint64_t{0});
  http::async_read(*stream_, buffer_, *parser_,
                   [self = shared_from_this()](const error_code& error, std::size_t) {
                     if (!error) {
                       self->handle();
                     } else {
                       self->refuse_garbage(error);
                     }
                   });
}

/// What is no request is answered too, once; what broke off is not.
void Connection::refuse_garbage(const error_code& error) {
  end_wait();
  const error_code of_http = http::error::bad_target;
  if (error.category() != of_http.category() || error == http::error::end_of_stream ||
      error == http::error::partial_message) {
    return;
  }
  const bool long_head = error == http::error::header_limit;
  Answer answer =
      made(long_head ? http::status::request_header_fields_too_large : http::status::bad_request,
           "text/plain", "this is no request that haptic-web can read\n");
  answer.version(11);
  answer.keep_alive(false);
  send(std::move(answer));
}

void Connection::handle() {
  end_wait();
  if (gave_way_) return;
  ++shared_->counters.requests;
  const auto& request = parser_->get();
  const std::string target(view_of(request.target()));
  if (!is_own_host(field(http::field::host), shared_->options.names)) {
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
  answer(target);
}

Connection::Answer Connection::made(http::status status, const std::string& type,
                                    std::string body) const {
  Answer answer(status, parser_->get().version());
  guard(answer, field(http::field::host));
  answer.set(http::field::content_type, type);
  answer.set(http::field::cache_control, "no-cache");
  answer.body() = std::move(body);
  answer.keep_alive(parser_->get().keep_alive());
  return answer;
}

void Connection::answer(const std::string& target) {
  if (target.starts_with(kAssetPath)) {
    begin_wait();  // A disk may be slow: who waits for it keeps nobody out either.
    return shared_->files->asset(target.substr(kAssetPath.size()),
                                 [self = shared_from_this()](std::optional<PageFile> file) {
                                   self->found(std::move(file), kNoAsset);
                                 });
  }
  if (target == "/metrics" && shared_->options.metrics) {
    return send(made(http::status::ok, "text/plain; version=0.0.4; charset=utf-8",
                     shared_->options.metrics()));
  }
  const std::string missing = target != "/"
                                  ? "there is no such file\n"
                                  : "there is no page in " + shared_->options.page.string() +
                                        ". Name its folder with --page\n";
  begin_wait();
  shared_->files->page(target, accepts_gzip(field(http::field::accept_encoding)),
                       [self = shared_from_this(), missing](std::optional<PageFile> file) {
                         self->found(std::move(file), missing);
                       });
}

void Connection::send(Answer answer) {
  answer_ = std::make_shared<Answer>(std::move(answer));
  answer_->prepare_payload();
  // HEAD wants the head of what GET would get.
  if (parser_->get().method() == http::verb::head) answer_->body().clear();
  begin_wait();
  http::async_write(*stream_, *answer_,
                    [self = shared_from_this()](const error_code& error, std::size_t) {
                      self->end_wait();
                      if (!error && !self->gave_way_ && self->answer_->keep_alive()) self->read();
                    });
}

void Connection::found(std::optional<PageFile> file, const std::string& missing) {
  if (gave_way_) return;
  if (!file.has_value()) return send(made(http::status::not_found, "text/plain", missing));
  file_ = std::move(file);
  const std::size_t all = file_->file->blocks();
  if (names(field(http::field::if_none_match), '"' + file_->file->hash() + '"')) {
    return write(head_of_file(http::status::not_modified), all);
  }
  if (parser_->get().method() == http::verb::head || all == 0) {
    return write(head_of_file(http::status::ok), all);
  }
  send_block(0);
}

std::string Connection::head_of_file(http::status status) const {
  http::response<http::empty_body> head(status, parser_->get().version());
  guard(head, field(http::field::host));
  head.set(http::field::content_type, file_->type);
  head.set(http::field::cache_control,
           file_->lasting ? "public, max-age=31536000, immutable" : "no-cache");
  // The hash of what is sent: packed it is another one.
  head.set(http::field::etag, '"' + file_->file->hash() + '"');
  head.set(http::field::accept_ranges, "none");
  if (file_->has_gzip) head.set(http::field::vary, "Accept-Encoding");
  if (file_->gzip) head.set(http::field::content_encoding, "gzip");
  if (status == http::status::ok) head.content_length(file_->file->size());
  head.keep_alive(parser_->get().keep_alive());
  std::ostringstream text;
  text << head.base();
  return std::move(text).str();
}

void Connection::send_block(std::size_t index) {
  begin_wait();
  shared_->files->block(
      file_->file, index, [self = shared_from_this(), index](std::optional<std::string> block) {
        if (self->gave_way_) return;
        if (block.has_value()) {
          self->outgoing_ = std::move(*block);
          self->write(index == 0 ? self->head_of_file(http::status::ok) : "", index + 1);
        } else if (index == 0) {
          self->send(self->made(http::status::not_found, "text/plain",
                                "this file is being changed. Ask again\n"));
        }
        // What was promised cannot be had any more: the browser sees that it broke off.
      });
}

/// Sends `head` and what is in outgoing_, and goes on with that block.
void Connection::write(std::string head, std::size_t next_block) {
  outgoing_.insert(0, head);
  begin_wait();
  boost::asio::async_write(
      *stream_, boost::asio::buffer(outgoing_),
      [self = shared_from_this(), next_block](const error_code& error, std::size_t) {
        self->end_wait();
        self->outgoing_ = {};
        if (error || self->gave_way_) return;
        if (next_block < self->file_->file->blocks()) return self->send_block(next_block);
        self->file_.reset();
        if (self->parser_->get().keep_alive()) self->read();
      });
}

void Connection::handshake() {
  const bool tls = stream_->tls() != nullptr;
  if (buffer_.size() > 0) {
    // RFC 6455, section 4.1: who shakes hands waits for the answer.
    return send(made(http::status::bad_request, "text/plain",
                     "frames come after the answer to the handshake\n"));
  }
  if (!may_look(field(http::field::origin), field(http::field::host), tls,
                shared_->options.names)) {
    ++shared_->counters.refused_origin;
    return send(made(http::status::forbidden, "text/plain", "not for pages from elsewhere\n"));
  }
  const std::string subprotocol = own_subprotocol(field(http::field::sec_websocket_protocol));
  const bool good = carries_token(subprotocol, shared_->options.token);
  if (!find_place(good)) {
    ++shared_->counters.refused_full;
    return send(made(http::status::service_unavailable, "text/plain",
                     "no place is left: --viewers limits their number, and a quarter of the "
                     "places is for pages with the token\n"));
  }
  if (!good && subprotocol.size() > kSubprotocol.size()) ++shared_->counters.bad_tokens;
  join(good, good && (tls || address_.is_loopback()), subprotocol);
}

/// Makes place for a viewer where there is none: for one with the token the looker goes that was
/// not heard for longest, for another looker one that is no page any more.
bool Connection::find_place(bool token) {
  Shared& shared = *shared_;
  const std::size_t most = shared.options.most_viewers;
  const std::size_t kept = shared.options.token.empty() ? 0 : most / 4;
  const std::int64_t now_ns = client::monotonic_now_ns();
  const bool full = shared.viewers >= most;
  if (token) {
    if (!full) return true;
    // One that went, and has not said goodbye yet, still counts as a viewer.
    return shared.lookers.evict(now_ns) || shared.viewers - shared.anonymous < most;
  }
  if (!full && shared.anonymous + kept < most) return true;
  return shared.lookers.evict(now_ns - shared.options.quiet.count());
}

void Connection::join(bool token, bool may, const std::string& subprotocol) {
  ++shared_->viewers;
  if (!token) ++shared_->anonymous;
  const auto number = std::make_shared<std::uint64_t>(0);  // in `lookers`
  ViewerPlace place;
  place.closed = [shared = shared_, address = address_, token, number] {
    --shared->viewers;
    if (!token) --shared->anonymous;
    shared->lookers.remove(*number);
    shared->door.leave(address);
  };
  if (!token) {
    place.heard = [shared = shared_, address = address_, number](std::function<void()> give_way) {
      shared->lookers.remove(*number);
      *number = shared->lookers.add(address, client::monotonic_now_ns(), std::move(give_way));
    };
  }
  place.host = std::string(field(http::field::host));
  place.message_time = shared_->options.message_time;
  const ViewerRights rights{may && shared_->options.control, may};
  const auto viewer =
      std::make_shared<Viewer>(std::move(*stream_), shared_->hub, rights, std::move(place));
  stream_.reset();
  viewer->accept(parser_->release(), subprotocol);
}

}  // namespace

boost::asio::ip::address remote_address(const boost::asio::ip::tcp::socket& socket) {
  error_code unknown;
  const boost::asio::ip::address address = socket.remote_endpoint(unknown).address();
  if (!address.is_v6() || !address.to_v6().is_v4_mapped()) return address;
  return boost::asio::ip::make_address_v4(boost::asio::ip::v4_mapped, address.to_v6());
}

void begin_connection(const std::shared_ptr<Shared>& shared, boost::asio::ip::tcp::socket socket,
                      const boost::asio::ip::address& from) {
  if (!shared->door.enter(from, client::monotonic_now_ns())) return;
  std::make_shared<Connection>(shared, std::move(socket), from)->begin();
}

}  // namespace hapticd::web
// NOLINTEND(misc-no-recursion)
