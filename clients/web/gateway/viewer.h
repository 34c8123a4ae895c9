// One browser's WebSocket: what the hub has for it is written, what it says is handed to the hub.
// Lives as long as its connection. One thread. Not RT.
#pragma once

#include <boost/asio/steady_timer.hpp>
#include <boost/beast/core/flat_buffer.hpp>
#include <boost/beast/http/empty_body.hpp>
#include <boost/beast/http/message.hpp>
#include <boost/beast/websocket/stream.hpp>
#include <chrono>
#include <functional>
#include <memory>
#include <string>
#include <string_view>

#include "clients/web/gateway/frame_watch.h"
#include "clients/web/gateway/hub.h"
#include "clients/web/gateway/page_stream.h"

namespace hapticd::web {

/// Longest message a page may send, bytes; a scene in LoadScene is the longest there is.
inline constexpr std::size_t kMaxMessageBytes = 1U << 20U;
/// Longest message of one that only looks: what is obeyed of it is short.
inline constexpr std::size_t kMaxLookerBytes = 16U << 10U;

/// What the server has of a viewer.
struct ViewerPlace {
  std::string host;              ///< by which it came
  std::function<void()> closed;  ///< called once, at the end
  /// It was heard, at first when it came; takes how it is told that it has to give way. May be
  /// empty: it need not.
  std::function<void(std::function<void()> give_way)> heard;
  /// From the first byte of a message to its last; who takes longer is closed.
  std::chrono::nanoseconds message_time{};
};

class Viewer : public std::enable_shared_from_this<Viewer> {
 public:
  using Request = boost::beast::http::request<boost::beast::http::empty_body>;

  /// `hub` must outlive the io_context's run.
  Viewer(PageStream stream, Hub& hub, ViewerRights rights, ViewerPlace place);
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
  void heard();
  void give_way();
  void came(std::string_view bytes);
  void await_rest();

  boost::beast::websocket::stream<PageStream> socket_;
  Hub& hub_;
  ViewerRights rights_;
  ViewerPlace place_;
  Request request_;
  boost::beast::flat_buffer incoming_;
  std::string outgoing_;
  FrameWatch frames_;
  boost::asio::steady_timer rest_timer_;
  bool awaits_rest_ = false;
  bool writing_ = false;
  ViewerId id_ = 0;  ///< 0 = not joined
};

}  // namespace hapticd::web
