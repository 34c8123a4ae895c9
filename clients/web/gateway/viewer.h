// One browser's WebSocket: what the hub has for it is written, what it says is handed to the hub.
// Lives as long as its connection. One thread. Not RT.
#pragma once

#include <boost/beast/core/flat_buffer.hpp>
#include <boost/beast/http/empty_body.hpp>
#include <boost/beast/http/message.hpp>
#include <boost/beast/websocket/stream.hpp>
#include <memory>
#include <string>

#include "clients/web/gateway/hub.h"
#include "clients/web/gateway/page_stream.h"

namespace hapticd::web {

/// Longest message a page may send, bytes; a scene in LoadScene is the longest there is.
inline constexpr std::size_t kMaxMessageBytes = 1U << 20U;

class Viewer : public std::enable_shared_from_this<Viewer> {
 public:
  using Request = boost::beast::http::request<boost::beast::http::empty_body>;

  /// `hub` must outlive the io_context's run. `closed` is called once, at the end.
  Viewer(PageStream stream, Hub& hub, bool control, std::function<void()> closed);
  ~Viewer();
  Viewer(const Viewer&) = delete;
  Viewer& operator=(const Viewer&) = delete;

  /// Answers the handshake, with this subprotocol unless it is empty; then joins the hub.
  void accept(Request request, const std::string& subprotocol);

 private:
  void join();
  void read();
  void write();
  void close(CloseReason reason);

  boost::beast::websocket::stream<PageStream> socket_;
  Hub& hub_;
  bool control_;
  std::function<void()> closed_;
  Request request_;
  boost::beast::flat_buffer incoming_;
  std::string outgoing_;
  bool writing_ = false;
  ViewerId id_ = 0;  ///< 0 = not joined
};

}  // namespace hapticd::web
