// See viewer.h.
#include "clients/web/gateway/viewer.h"

#include <boost/asio/buffer.hpp>
#include <boost/asio/post.hpp>
#include <boost/beast/websocket/rfc6455.hpp>
#include <chrono>
#include <utility>

#include "clients/library/client.h"
#include "clients/web/gateway/answer_head.h"

// NOLINTBEGIN(misc-no-recursion): handlers that begin the next step look like recursion.
namespace hapticd::web {

namespace asio = boost::asio;
namespace websocket = boost::beast::websocket;
using boost::system::error_code;

namespace {

/// Time for the handshake, and for a goodbye.
constexpr std::chrono::seconds kHandshake{5};
/// Silence after which a viewer is gone; half of it, and it is pinged.
constexpr std::chrono::seconds kIdle{20};

websocket::close_reason reason_of(CloseReason reason) {
  switch (reason) {
    case CloseReason::kTooSlow:
      return {websocket::close_code::try_again_later, "too slow"};
    case CloseReason::kGarbage:
      return {websocket::close_code::bad_payload, "no PageRequest"};
    case CloseReason::kUnfinished:
      return {websocket::close_code::policy_error, "a message did not end in time"};
    case CloseReason::kGaveWay:
      return {websocket::close_code::try_again_later,
              "a page that may do more, or one that was heard later, needed this place"};
    case CloseReason::kEnd:
      break;
  }
  return {websocket::close_code::going_away, "the gateway ends"};
}

}  // namespace

void teardown(boost::beast::role_type role, PageStream& stream, error_code& error) {
  if (stream.tls() != nullptr) {
    boost::beast::teardown(role, *stream.tls(), error);
  } else {
    websocket::teardown(role, stream.next_layer().socket(), error);
  }
}

Viewer::Viewer(PageStream stream, Hub& hub, ViewerRights rights, ViewerPlace place)
    : socket_(std::move(stream)),
      hub_(hub),
      rights_(rights),
      place_(std::move(place)),
      rest_timer_(socket_.get_executor()) {}

Viewer::~Viewer() {
  if (id_ != 0) hub_.remove(id_);
  if (place_.closed) place_.closed();
}

void Viewer::heard() {
  if (!place_.heard) return;
  place_.heard([weak = weak_from_this()] {
    if (const auto self = weak.lock()) self->give_way();
  });
}

void Viewer::give_way() {
  // From here on it is as good as gone.
  place_.heard = {};
  if (id_ != 0) {
    hub_.end(id_, CloseReason::kGaveWay);
  } else {
    socket_.next_layer().next_layer().close();
  }
}

void Viewer::accept(Request request, const std::string& subprotocol) {
  request_ = std::move(request);
  heard();
  // Deadlines are the WebSocket's own from here on.
  socket_.next_layer().next_layer().expires_never();
  websocket::stream_base::timeout times{};
  times.handshake_timeout = kHandshake;
  times.idle_timeout = kIdle;
  times.keep_alive_pings = true;
  socket_.set_option(times);
  socket_.set_option(websocket::stream_base::decorator(
      [subprotocol, host = place_.host](websocket::response_type& response) {
        guard(response, host);
        if (!subprotocol.empty()) {
          response.set(boost::beast::http::field::sec_websocket_protocol, subprotocol);
        }
      }));
  const bool looks = !rights_.control && !rights_.steer;
  socket_.read_message_max(looks ? kMaxLookerBytes : kMaxMessageBytes);
  socket_.binary(true);
  // One event, one frame: nothing that has to come in between is worth the many writes.
  socket_.auto_fragment(false);
  socket_.async_accept(request_, [self = shared_from_this()](const error_code& error) {
    if (!error) self->join();
  });
}

void Viewer::join() {
  ViewerPort port;
  // The hub does not keep a viewer alive: its reading does.
  port.wake = [weak = weak_from_this()] {
    if (const auto self = weak.lock()) {
      // Later: the hub may be in the middle of its viewers, and this one has no number yet.
      if (!self->writing_) asio::post(self->socket_.get_executor(), [self] { self->write(); });
    }
  };
  port.close = [weak = weak_from_this()](CloseReason reason) {
    if (const auto self = weak.lock()) {
      asio::post(self->socket_.get_executor(), [self, reason] { self->close(reason); });
    }
  };
  id_ = hub_.add(rights_, std::move(port));
  socket_.next_layer().on_bytes([this](std::string_view bytes) { came(bytes); });
  read();
}

/// Pongs keep a silent viewer; half a message, and one byte of it now and then, do not.
void Viewer::came(std::string_view bytes) {
  frames_.take(bytes, client::monotonic_now_ns());
  if (!awaits_rest_) await_rest();
}

void Viewer::await_rest() {
  const auto since_ns = frames_.unfinished_since_ns();
  awaits_rest_ = since_ns.has_value();
  if (!awaits_rest_) return;
  const std::chrono::nanoseconds passed{client::monotonic_now_ns() - *since_ns};
  if (passed >= place_.message_time) return hub_.end(id_, CloseReason::kUnfinished);
  rest_timer_.expires_after(place_.message_time - passed);
  rest_timer_.async_wait([weak = weak_from_this()](const error_code& cancelled) {
    const auto self = weak.lock();
    if (!cancelled && self != nullptr) self->await_rest();
  });
}

void Viewer::read() {
  socket_.async_read(incoming_, [self = shared_from_this()](const error_code& error, std::size_t) {
    if (error) {
      // Whoever closed it: nothing refers to it any more.
      const bool garbage = error == websocket::condition::protocol_violation ||
                           error == websocket::error::message_too_big;
      if (garbage) self->hub_.end(self->id_, CloseReason::kGarbage);
      return;
    }
    self->heard();
    const auto bytes = self->incoming_.cdata();
    self->hub_.take(self->id_, {static_cast<const char*>(bytes.data()), bytes.size()});
    self->incoming_.consume(self->incoming_.size());
    self->read();
  });
}

void Viewer::write() {
  if (writing_) return;
  auto next = hub_.next(id_);
  if (!next.has_value()) return;
  outgoing_ = std::move(*next);
  writing_ = true;
  socket_.async_write(asio::buffer(outgoing_),
                      [self = shared_from_this()](const error_code& error, std::size_t) {
                        self->writing_ = false;
                        if (!error) self->write();
                      });
}

void Viewer::close(CloseReason reason) {
  socket_.async_close(reason_of(reason), [self = shared_from_this()](const error_code&) {
    // Who does not take the goodbye either is cut off.
    self->socket_.next_layer().next_layer().close();
  });
}

}  // namespace hapticd::web
// NOLINTEND(misc-no-recursion)
