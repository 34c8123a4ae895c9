// See page_connection_target.h.
#include "tests/fuzz/page_connection_target.h"

#include <algorithm>
#include <array>
#include <boost/asio/io_context.hpp>
#include <boost/asio/write.hpp>
#include <chrono>
#include <memory>
#include <stdexcept>
#include <string>
#include <string_view>
#include <utility>

#include "clients/web/gateway/http_connection.h"

namespace hapticd::test {
namespace {

namespace asio = boost::asio;
using Tcp = asio::ip::tcp;
using boost::system::error_code;

/// What is sent at most: what a socket takes at once.
constexpr std::size_t kMostBytes = 32U << 10U;
constexpr std::string_view kEndOfHead = "\r\n\r\n";
/// For an answer to a first head, which may need more: looks, and the longest time of one.
constexpr int kLooks = 20;
constexpr std::chrono::milliseconds kLook{5};
/// Far more than it takes: only what never ends fails.
constexpr std::chrono::seconds kDeadline{20};

void require(bool condition, const char* what) {
  if (!condition) throw std::logic_error(what);
}

class Server {
 public:
  Server() : hub_(hub_options()), shared_(make()) {}
  ~Server() { shared_->files.reset(); }
  Server(const Server&) = delete;
  Server& operator=(const Server&) = delete;

  /// What a peer that sends `bytes` is answered.
  std::string talk(std::span<const std::uint8_t> bytes) {
    Tcp::socket peer(context_, Tcp::v4());
    // From an address of its own: a port is not free again for a minute.
    const unsigned number = ++talks_ % 65'000;
    peer.bind({asio::ip::address_v4(0x7f010000U + number), 0});
    peer.connect(shared_->acceptor.local_endpoint());
    Tcp::socket accepted = shared_->acceptor.accept();
    const asio::ip::address from = web::remote_address(accepted);
    web::begin_connection(shared_, std::move(accepted), from);
    peer.non_blocking(true);
    std::string answer;
    say(peer, bytes, answer);
    const auto end = std::chrono::steady_clock::now() + kDeadline;
    while (shared_->door.size() > 0) {
      context_.restart();
      context_.run_one_for(kDeadline);
      read(peer, answer);
      require(std::chrono::steady_clock::now() < end, "a connection outlives its peer");
    }
    read(peer, answer);
    require(shared_->viewers == 0 && shared_->anonymous == 0 && hub_.viewers() == 0,
            "a viewer outlives its connection");
    require(shared_->door.waiting() == 0 && shared_->lookers.size() == 0,
            "a place is taken by nobody");
    return answer;
  }
  [[nodiscard]] int moved() const { return moved_; }
  [[nodiscard]] std::uint64_t welcomed() const { return hub_.counters().viewers_ever; }

 private:
  web::HubOptions hub_options() {
    web::HubOptions made;
    made.call = [this](const v1::Item& item, const client::ResultHandler&) {
      // A page that goes gives back what it may have got.
      if (!item.has_release()) ++moved_;
      return false;
    };
    made.steer = [this](const v1::PagePlayback&) { ++moved_; };
    made.show = [this](const std::string&, const web::Answer&) { ++moved_; };
    made.recordings = [this] {
      ++moved_;
      return v1::Listing();
    };
    made.experiment = [this](web::ViewerId, bool control, const v1::PageExperiment&) {
      if (control) ++moved_;
      return v1::Result();
    };
    return made;
  }
  std::shared_ptr<web::HttpServer::Shared> make() {
    web::ServerOptions options;
    options.port = 0;
    options.token = kFuzzToken;
    options.page = "/proc/self";  // its files change while they are read
    options.metrics = [] { return std::string("metrics 1\n"); };
    return std::make_shared<web::HttpServer::Shared>(context_, std::move(options), hub_);
  }
  /// All of them; what comes behind a first head after its answer, as frames have to.
  void say(Tcp::socket& peer, std::span<const std::uint8_t> bytes, std::string& answer) {
    const std::string_view text(reinterpret_cast<const char*>(bytes.data()), bytes.size());
    const std::size_t head =
        std::min(std::min(text.find(kEndOfHead), text.size()) + kEndOfHead.size(), text.size());
    error_code gone;
    asio::write(peer, asio::buffer(text.data(), head), gone);
    for (int i = 0; i < kLooks && head < text.size() && answer.empty(); ++i) {
      if (shared_->door.size() == 0) break;
      context_.restart();
      context_.run_one_for(kLook);
      read(peer, answer);
    }
    asio::write(peer, asio::buffer(text.data() + head, text.size() - head), gone);
    peer.shutdown(Tcp::socket::shutdown_send, gone);
  }
  static void read(Tcp::socket& peer, std::string& answer) {
    std::array<char, 4096> bytes{};
    error_code none;
    while (const std::size_t more = peer.read_some(asio::buffer(bytes), none)) {
      answer.append(bytes.data(), more);
    }
  }

  int moved_ = 0;
  unsigned talks_ = 0;
  web::Hub hub_;
  asio::io_context context_{1};
  std::shared_ptr<web::HttpServer::Shared> shared_;
};

}  // namespace

bool check_page_connection(std::span<const std::uint8_t> bytes) {
  static Server server;
  const int moved = server.moved();
  const std::uint64_t welcomed = server.welcomed();
  const auto sent = bytes.first(std::min(bytes.size(), kMostBytes));
  const std::string answer = server.talk(sent);
  const std::string_view head = std::string_view(answer).substr(0, answer.find("\r\n\r\n"));
  require(answer.empty() || head.starts_with("HTTP/1."), "the answer is not HTTP");
  require(answer.empty() || head.find("Content-Security-Policy: default-src 'none'") != head.npos,
          "an answer without a policy");
  const std::string_view text(reinterpret_cast<const char*>(sent.data()), sent.size());
  require(server.moved() == moved || text.find(kFuzzToken) != text.npos,
          "something was done for who did not send the token");
  return server.welcomed() > welcomed;
}

}  // namespace hapticd::test
