// A TCP connection with a browser, with TLS or without: one type for both, so that HTTP and
// WebSocket are compiled once. What Boost.Beast asks of a stream. Not RT.
#pragma once

#include <boost/asio/async_result.hpp>
#include <boost/asio/buffer.hpp>
#include <boost/asio/compose.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/ssl/context.hpp>
#include <boost/beast/core/tcp_stream.hpp>
#include <boost/beast/ssl/ssl_stream.hpp>
#include <boost/beast/websocket/teardown.hpp>
#include <cstddef>
#include <functional>
#include <memory>
#include <string_view>
#include <utility>

// NOLINTBEGIN(misc-no-recursion): handlers that begin the next step look like recursion.
namespace hapticd::web {

class PageStream {
 public:
  using Tcp = boost::beast::tcp_stream;
  using Tls = boost::beast::ssl_stream<Tcp&>;
  // NOLINTBEGIN(readability-identifier-naming): Boost's names.
  using executor_type = Tcp::executor_type;
  using next_layer_type = Tcp;
  // NOLINTEND(readability-identifier-naming)

  /// With `tls` the handshake is the owner's to begin: tls()->async_handshake().
  explicit PageStream(boost::asio::ip::tcp::socket socket, boost::asio::ssl::context* tls)
      : tcp_(std::make_unique<Tcp>(std::move(socket))) {
    if (tls != nullptr) tls_ = std::make_unique<Tls>(*tcp_, *tls);
  }

  /// Below; where deadlines are set.
  [[nodiscard]] Tcp& next_layer() noexcept { return *tcp_; }
  [[nodiscard]] const Tcp& next_layer() const noexcept { return *tcp_; }
  /// Null without TLS.
  [[nodiscard]] Tls* tls() noexcept { return tls_.get(); }
  /// From here on told of all bytes that come, plain, before who reads them is.
  void on_bytes(std::function<void(std::string_view)> told) { told_ = std::move(told); }
  // The name is Boost.Asio's.
  [[nodiscard]] executor_type get_executor() noexcept { return tcp_->get_executor(); }

  template <typename Buffers, typename Token>
  auto async_read_some(const Buffers& buffers, Token&& token) {
    return boost::asio::async_compose<Token, void(boost::system::error_code, std::size_t)>(
        [this, buffers, begun = false](auto& self, boost::system::error_code error = {},
                                       std::size_t count = 0) mutable {
          if (begun) {
            tell(buffers, count);
            return self.complete(error, count);
          }
          begun = true;
          const Buffers into = buffers;  // moved with `self`
          if (tls_ != nullptr) {
            tls_->async_read_some(into, std::move(self));
          } else {
            tcp_->async_read_some(into, std::move(self));
          }
        },
        token, *tcp_);
  }

  template <typename Buffers, typename Token>
  auto async_write_some(const Buffers& buffers, Token&& token) {
    return boost::asio::async_initiate<Token, void(boost::system::error_code, std::size_t)>(
        [this](auto&& handler, const Buffers& from) {
          if (tls_ != nullptr) {
            tls_->async_write_some(from, std::forward<decltype(handler)>(handler));
          } else {
            tcp_->async_write_some(from, std::forward<decltype(handler)>(handler));
          }
        },
        token, buffers);
  }

 private:
  /// Of what was read into `buffers`.
  template <typename Buffers>
  void tell(const Buffers& buffers, std::size_t count) {
    if (!told_) return;
    const auto end = boost::asio::buffer_sequence_end(buffers);
    for (auto at = boost::asio::buffer_sequence_begin(buffers); at != end && count > 0; ++at) {
      const boost::asio::mutable_buffer part = boost::asio::buffer(*at, count);
      told_({static_cast<const char*>(part.data()), part.size()});
      count -= part.size();
    }
  }

  std::unique_ptr<Tcp> tcp_;
  std::unique_ptr<Tls> tls_;
  std::function<void(std::string_view)> told_;
};

/// How a WebSocket over it ends; found by Boost.Beast by its name.
void teardown(boost::beast::role_type role, PageStream& stream, boost::system::error_code& error);

template <typename Handler>
void async_teardown(boost::beast::role_type role, PageStream& stream, Handler&& handler) {
  using boost::beast::websocket::async_teardown;
  if (stream.tls() != nullptr) {
    async_teardown(role, *stream.tls(), std::forward<Handler>(handler));
  } else {
    async_teardown(role, stream.next_layer().socket(), std::forward<Handler>(handler));
  }
}

}  // namespace hapticd::web
// NOLINTEND(misc-no-recursion)
