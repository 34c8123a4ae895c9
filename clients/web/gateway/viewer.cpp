// See viewer.h.
#include "clients/web/gateway/viewer.h"

#include <boost/asio/buffer.hpp>
#include <boost/asio/post.hpp>
#include <boost/beast/websocket/rfc6455.hpp>
#include <chrono>
#include <utility>

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

Viewer::Viewer(PageStream stream, Hub& hub, bool control, std::function<void()> closed)
    : socket_(std::move(stream)), hub_(hub), control_(control), closed_(std::move(closed)) {}

Viewer::~Viewer() {
  if (id_ != 0) hub_.remove(id_);
  if (closed_) closed_();
}

void Viewer::accept(Request request, const std::string& subprotocol) {
  request_ = std::move(request);
  // Deadlines are the WebSocket's own from here on.
  socket_.next_layer().next_layer().expires_never();
  websocket::stream_base::timeout times{};
  times.handshake_timeout = kHandshake;
  times.idle_timeout = kIdle;
  times.keep_alive_pings = true;
  socket_.set_option(times);
  socket_.set_option(websocket::stream_base::decorator([subprotocol](auto& response) {
    if (!subprotocol.empty()) {
      response.set(boost::beast::http::field::sec_websocket_protocol, subprotocol);
    }
  }));
  socket_.read_message_max(kMaxMessageBytes);
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
  id_ = hub_.add(control_, std::move(port));
  read();
}

void Viewer::read() {
  socket_.async_read(incoming_, [self = shared_from_this()](const error_code& error, std::size_t) {
    if (error) return;  // Whoever closed it: nothing refers to it any more.
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
