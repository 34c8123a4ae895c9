// See daemon_link.h.
#include "clients/web/gateway/daemon_link.h"

#include <sys/random.h>

#include <algorithm>
#include <array>
#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/udp.hpp>
#include <boost/asio/steady_timer.hpp>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <stdexcept>
#include <utility>

#include "clients/library/client.h"
#include "clients/library/program.h"

namespace hapticd::web {
namespace {

namespace asio = boost::asio;
using boost::system::error_code;
using Udp = asio::ip::udp;

/// Longest wait between two looks at what is due.
constexpr std::int64_t kMaxWait_ns = 10'000'000;
/// Time until a socket that could not be opened is tried again.
constexpr std::chrono::seconds kOpenAgain{1};
/// Silence after which another socket is opened, ns.
constexpr std::int64_t kOtherSocket_ns = 12'000'000'000;
constexpr std::size_t kBufferBytes = 2048;
constexpr int kSocketBytes = 1 << 20;
constexpr std::uint32_t kMaxContacts = 64;

std::uint32_t random_number() {
  std::uint32_t number = 0;
  if (getrandom(&number, sizeof number, 0) != static_cast<ssize_t>(sizeof number)) {
    throw std::runtime_error("the system provides no random numbers");
  }
  return number;
}

v1::Item subscription(double state_rate_hz, double tick_rate_hz) {
  v1::Item item;
  v1::Subscribe& subscribe = *item.mutable_subscribe();
  subscribe.set_divisor(client::state_divisor(tick_rate_hz, state_rate_hz));
  for (int section = v1::SECTION_TOOLS; section <= v1::SECTION_REPLAY; ++section) {
    subscribe.add_sections(static_cast<v1::Section>(section));
  }
  subscribe.set_max_contacts(kMaxContacts);
  return item;
}

}  // namespace

/// All of a link, as long as one of its handlers waits.
class DaemonLink::Implementation : public std::enable_shared_from_this<Implementation> {
 public:
  Implementation(asio::io_context& context, LinkOptions given, LinkHandlers told)
      : options_(std::move(given)),
        handlers_(std::move(told)),
        resolver_(context),
        socket_(context),
        timer_(context) {
    facts_.server = options_.host + ":" + std::to_string(options_.port);
    facts_.keyed = options_.key.has_value();
  }

 private:
  friend DaemonLink;

  void make_core();
  void open();
  void connect(const Udp::resolver::results_type& found);
  void open_again(const error_code& error);
  void receive();
  void received(std::size_t bytes);
  void send(std::span<const std::uint8_t> datagram);
  void trouble(const error_code& error);
  void poll();
  void wait();
  void ended(client::SessionEnd how);
  void heard_item(const v1::Item& item);

  LinkOptions options_;
  LinkHandlers handlers_;
  Udp::resolver resolver_;
  Udp::socket socket_;
  asio::steady_timer timer_;
  std::array<std::uint8_t, kBufferBytes> buffer_{};
  std::unique_ptr<client::ClientCore> core_;
  LinkFacts facts_;
  LinkMeter meter_;
  double tick_rate_hz_ = 1000.0;
  std::int64_t opened_ns_ = 0;
  std::uint64_t sessions_ended_ = 0;
  bool stopped_ = false;
};

void DaemonLink::Implementation::make_core() {
  client::ClientHandlers told;
  told.item = [this](const v1::Item& item) { heard_item(item); };
  told.state = handlers_.state;
  told.ended = [this](client::SessionEnd how) { ended(how); };
  core_ = std::make_unique<client::ClientCore>(
      [this](std::span<const std::uint8_t> datagram) { send(datagram); }, random_number,
      std::move(told), options_.key);
  core_->request(subscription(options_.state_rate_hz, tick_rate_hz_));
}

void DaemonLink::Implementation::heard_item(const v1::Item& item) {
  if (item.has_scene_info()) {
    const double rate_hz = item.scene_info().rate_hz();
    if (rate_hz > 0.0 && rate_hz != tick_rate_hz_) {
      tick_rate_hz_ = rate_hz;
      core_->request(subscription(options_.state_rate_hz, tick_rate_hz_));
    }
  }
  if (handlers_.item) handlers_.item(item);
}

void DaemonLink::Implementation::ended(client::SessionEnd how) {
  ++sessions_ended_;
  facts_.full = how == client::SessionEnd::kFull;
  facts_.said_bye = how == client::SessionEnd::kBye;
  facts_.bye_message = facts_.said_bye ? core_->bye().message() : "";
  if (handlers_.ended) handlers_.ended();
}

void DaemonLink::Implementation::open() {
  if (stopped_) return;
  opened_ns_ = client::monotonic_now_ns();
  if (facts_.began_ns == 0) facts_.began_ns = opened_ns_;
  resolver_.async_resolve(options_.host, std::to_string(options_.port),
                          [self = shared_from_this()](const error_code& error, const auto& found) {
                            self->facts_.unknown_name = static_cast<bool>(error);
                            if (error) return self->open_again(error);
                            self->connect(found);
                          });
}

void DaemonLink::Implementation::connect(const Udp::resolver::results_type& found) {
  if (stopped_) return;
  error_code error;
  for (const auto& each : found) {
    error_code ignored;
    socket_.close(ignored);
    socket_.open(each.endpoint().protocol(), error);
    if (!error) socket_.connect(each.endpoint(), error);
    if (!error) break;
  }
  if (error) return open_again(error);
  error_code ignored;  // Less is not a fault: what does not fit is repeated.
  socket_.set_option(Udp::socket::receive_buffer_size(kSocketBytes), ignored);
  socket_.non_blocking(true, ignored);
  receive();
  poll();
}

void DaemonLink::Implementation::open_again(const error_code& error) {
  trouble(error);
  timer_.expires_after(kOpenAgain);
  timer_.async_wait([self = shared_from_this()](const error_code& cancelled) {
    if (!cancelled) self->open();
  });
}

void DaemonLink::Implementation::trouble(const error_code& error) {
  if (error == asio::error::operation_aborted || error == asio::error::would_block) return;
  facts_.trouble = error.value();
  facts_.trouble_text = error.message();
  facts_.trouble_ns = client::monotonic_now_ns();
}

void DaemonLink::Implementation::send(std::span<const std::uint8_t> datagram) {
  error_code error;
  socket_.send(asio::buffer(datagram.data(), datagram.size()), 0, error);
  if (error) trouble(error);
}

void DaemonLink::Implementation::receive() {
  socket_.async_receive(asio::buffer(buffer_),
                        [self = shared_from_this()](const error_code& error, std::size_t bytes) {
                          if (error == asio::error::operation_aborted || self->stopped_) return;
                          if (error) {
                            self->trouble(error);
                          } else {
                            self->received(bytes);
                          }
                          self->receive();
                          self->poll();
                        });
}

void DaemonLink::Implementation::received(std::size_t bytes) {
  const std::int64_t now_ns = client::monotonic_now_ns();
  const std::span<const std::uint8_t> datagram(buffer_.data(), bytes);
  if (bytes >= wire::kHeaderBytes && datagram[0] == 'H' && datagram[1] != wire::kWireMajor) {
    facts_.other_major = datagram[1];
    facts_.other_major_ns = now_ns;
  }
  const auto header = wire::decode_header(datagram);
  const std::int64_t heard_ns = core_->heard_ns();
  const std::uint64_t ended_before = sessions_ended_;
  core_->receive(datagram, now_ns);
  const bool valid = core_->heard_ns() == now_ns && heard_ns != now_ns;
  if (valid) {
    facts_.heard_ns = now_ns;
    if (sessions_ended_ == ended_before) facts_.full = facts_.said_bye = false;
  } else if (sessions_ended_ != ended_before) {
    facts_.heard_ns = now_ns;  // A Reset or another boot_id is a word of the daemon too.
  }
  meter_.take(valid ? &*header : nullptr, bytes);
}

void DaemonLink::Implementation::poll() {
  if (stopped_) return;
  const std::int64_t now_ns = client::monotonic_now_ns();
  const std::int64_t heard_ns = std::max(opened_ns_, facts_.heard_ns);
  if (now_ns - heard_ns > kOtherSocket_ns) {
    error_code ignored;
    socket_.close(ignored);
    open();
    return;
  }
  core_->poll(now_ns);
  wait();
}

void DaemonLink::Implementation::wait() {
  const std::int64_t until_due = core_->due_ns() - client::monotonic_now_ns();
  timer_.expires_after(
      std::chrono::nanoseconds(std::clamp<std::int64_t>(until_due, 0, kMaxWait_ns)));
  timer_.async_wait([self = shared_from_this()](const error_code& cancelled) {
    if (!cancelled) self->poll();
  });
}

DaemonLink::DaemonLink(asio::io_context& context, LinkOptions options, LinkHandlers handlers)
    : implementation_(
          std::make_shared<Implementation>(context, std::move(options), std::move(handlers))) {
  implementation_->make_core();
}

DaemonLink::~DaemonLink() {
  try {
    stop();
  } catch (const std::exception& error) {
    std::fprintf(stderr, "haptic-web: could not say goodbye to the daemon: %s\n", error.what());
  }
}

void DaemonLink::start() { implementation_->open(); }

void DaemonLink::stop() {
  Implementation& mine = *implementation_;
  if (mine.stopped_) return;
  mine.stopped_ = true;
  mine.handlers_ = {};
  if (mine.socket_.is_open()) {
    mine.core_->leave(client::monotonic_now_ns());
    mine.core_->poll(client::monotonic_now_ns());
  }
  error_code ignored;
  mine.socket_.close(ignored);
  mine.resolver_.cancel();
  mine.timer_.cancel();
}

bool DaemonLink::request(const v1::Item& item, client::ResultHandler done) {
  if (verdict().state != v1::PAGE_LINK_STATE_LIVE) return false;
  if (implementation_->core_->request(item, std::move(done)) == 0) return false;
  implementation_->poll();
  return true;
}

LinkVerdict DaemonLink::verdict() const {
  return judge(implementation_->facts_, client::monotonic_now_ns());
}

v1::PageLink DaemonLink::report() {
  const std::int64_t now_ns = client::monotonic_now_ns();
  const LinkVerdict verdict = judge(implementation_->facts_, now_ns);
  v1::PageLink link;
  link.set_state(verdict.state);
  link.set_message(verdict.message);
  const wire::ClockEstimate& clock = implementation_->core_->clock();
  if (clock.known()) {
    const wire::ClockRelation relation = clock.at(now_ns);
    link.set_clock_offset_s(static_cast<double>(relation.offset_ns) * 1e-9);
    link.set_clock_error_s(static_cast<double>(relation.uncertainty_ns) * 1e-9);
    link.set_round_trip_s(static_cast<double>(clock.round_trip_ns()) * 1e-9);
  }
  const LinkQuality quality = implementation_->meter_.roll(now_ns);
  link.set_loss(quality.loss);
  link.set_bytes_per_s(quality.bytes_per_s);
  return link;
}

std::int64_t DaemonLink::daemon_now_ns() const {
  const wire::ClockEstimate& clock = implementation_->core_->clock();
  if (!clock.known()) return 0;
  const std::int64_t now_ns = client::monotonic_now_ns();
  return now_ns + clock.at(now_ns).offset_ns;
}

std::uint64_t DaemonLink::received_bytes() const { return implementation_->meter_.total_bytes(); }

std::uint64_t DaemonLink::sessions_ended() const { return implementation_->sessions_ended_; }

}  // namespace hapticd::web
