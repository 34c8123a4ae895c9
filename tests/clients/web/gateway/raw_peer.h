// A peer of the gateway that says what it likes, also what no browser would. Blocking. And what the
// gateway costs this process.
#pragma once

#include <doctest/doctest.h>

#include <boost/asio/buffer.hpp>
#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/read.hpp>
#include <boost/asio/read_until.hpp>
#include <boost/asio/write.hpp>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <string>
#include <vector>

namespace hapticd::test {

class Peer {
 public:
  /// From that address of loopback; with `receive_bytes` the system takes little for who does not
  /// read.
  explicit Peer(std::uint16_t port, int receive_bytes = 0, const std::string& from = "127.0.0.1") {
    socket_.open(boost::asio::ip::tcp::v4());
    if (receive_bytes > 0) {
      socket_.set_option(boost::asio::socket_base::receive_buffer_size(receive_bytes));
    }
    socket_.bind({boost::asio::ip::make_address(from), 0});
    socket_.connect({boost::asio::ip::make_address("127.0.0.1"), port});
  }
  void say(const std::string& bytes) { boost::asio::write(socket_, boost::asio::buffer(bytes)); }
  /// As far as it is still listened to.
  void try_to_say(const std::string& bytes) {
    boost::system::error_code gone;
    boost::asio::write(socket_, boost::asio::buffer(bytes), gone);
  }
  /// The head of what it is answered.
  std::string head() {
    const std::size_t length =
        boost::asio::read_until(socket_, boost::asio::dynamic_buffer(rest_), "\r\n\r\n");
    std::string text = rest_.substr(0, length);
    rest_.erase(0, length);
    return text;
  }
  /// Bytes behind the head until it is closed, however that is.
  std::size_t body() {
    std::vector<char> bytes(1U << 16U);
    boost::system::error_code closed;
    std::size_t all = rest_.size();
    while (!closed) all += socket_.read_some(boost::asio::buffer(bytes), closed);
    return all;
  }
  /// Behind the head of a handshake: the code of the WebSocket's goodbye (RFC 6455, section 5.5.1);
  /// 0: it broke off without one.
  unsigned goodbye() {
    constexpr unsigned kClose = 0x88;
    for (;;) {
      if (!have(2)) return 0;
      std::size_t length = byte(1);
      const std::size_t wide = length == 127 ? 8 : (length == 126 ? 2 : 0);
      if (!have(2 + wide)) return 0;
      if (wide > 0) length = 0;
      for (std::size_t i = 0; i < wide; ++i) length = length << 8U | byte(2 + i);
      if (!have(2 + wide + length)) return 0;
      if (byte(0) == kClose) return length < 2 ? 0 : byte(2) << 8U | byte(3);
      rest_.erase(0, 2 + wide + length);
    }
  }

 private:
  /// Whether as many bytes came.
  bool have(std::size_t count) {
    boost::system::error_code closed;
    if (rest_.size() < count) {
      boost::asio::read(socket_, boost::asio::dynamic_buffer(rest_),
                        boost::asio::transfer_exactly(count - rest_.size()), closed);
    }
    return rest_.size() >= count;
  }
  [[nodiscard]] unsigned byte(std::size_t i) const {
    return static_cast<unsigned char>(rest_.at(i));
  }

  boost::asio::io_context context_;
  boost::asio::ip::tcp::socket socket_{context_};
  std::string rest_;  ///< came, and was not looked at
};

inline std::string get(const std::string& target) {
  return "GET " + target + " HTTP/1.1\r\nHost: 127.0.0.1\r\n\r\n";
}

/// Of a page that only looks.
inline std::string handshake() {
  return "GET /stream HTTP/1.1\r\nHost: 127.0.0.1\r\nUpgrade: websocket\r\nConnection: Upgrade\r\n"
         "Sec-WebSocket-Version: 13\r\nSec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==\r\n\r\n";
}

/// Memory of this process that no file backs, bytes.
inline std::size_t anonymous_bytes() {
  std::ifstream status("/proc/self/status");
  std::string word;
  while (status >> word) {
    std::size_t kilobytes = 0;
    if (word == "RssAnon:" && status >> kilobytes) return kilobytes * 1024;
  }
  FAIL("the system does not tell");
  return 0;
}

/// Descriptors that this process has open.
inline std::size_t descriptors() {
  namespace fs = std::filesystem;
  const fs::directory_iterator all("/proc/self/fd");
  return static_cast<std::size_t>(std::distance(begin(all), end(all)));
}

}  // namespace hapticd::test
