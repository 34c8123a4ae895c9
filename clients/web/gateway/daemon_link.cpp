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
  subscribe.set_divisor(
      static_cast<std::uint32_t>(std::max(1.0, std::round(tick_rate_hz / state_rate_hz))));
  for (int section = v1::SECTION_TOOLS; section <= v1::SECTION_REPLAY; ++section) {
    subscribe.add_sections(static_cast<v1::Section>(section));
  }
  subscribe.set_max_contacts(kMaxContacts);
  return item;
}

}  // namespace

struct DaemonLink::Implementation : std::enable_shared_from_this<Implementation> {
  Implementation(asio::io_context& context, LinkOptions given, LinkHandlers told)
      : options(std::move(given)),
        handlers(std::move(told)),
        resolver(context),
        socket(context),
        timer(context) {
    facts.server = options.host + ":" + std::to_string(options.port);
    facts.keyed = options.key.has_value();
  }

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

  LinkOptions options;
  LinkHandlers handlers;
  Udp::resolver resolver;
  Udp::socket socket;
  asio::steady_timer timer;
  std::array<std::uint8_t, kBufferBytes> buffer{};
  std::unique_ptr<client::ClientCore> core;
  LinkFacts facts;
  LinkMeter meter;
  double tick_rate_hz = 1000.0;
  std::int64_t opened_ns = 0;
  std::uint64_t sessions_ended = 0;
  bool stopped = false;
};

void DaemonLink::Implementation::make_core() {
  client::ClientHandlers told;
  told.item = [this](const v1::Item& item) { heard_item(item); };
  told.state = handlers.state;
  told.ended = [this](client::SessionEnd how) { ended(how); };
  core = std::make_unique<client::ClientCore>(
      [this](std::span<const std::uint8_t> datagram) { send(datagram); }, random_number,
      std::move(told), options.key);
  core->request(subscription(options.state_rate_hz, tick_rate_hz));
}

void DaemonLink::Implementation::heard_item(const v1::Item& item) {
  if (item.has_scene_info()) {
    const double rate_hz = item.scene_info().rate_hz();
    if (rate_hz > 0.0 && rate_hz != tick_rate_hz) {
      tick_rate_hz = rate_hz;
      core->request(subscription(options.state_rate_hz, tick_rate_hz));
    }
  }
  if (handlers.item) handlers.item(item);
}

void DaemonLink::Implementation::ended(client::SessionEnd how) {
  ++sessions_ended;
  facts.full = how == client::SessionEnd::kFull;
  facts.said_bye = how == client::SessionEnd::kBye;
  facts.bye_message = facts.said_bye ? core->bye().message() : "";
  if (handlers.ended) handlers.ended();
}

void DaemonLink::Implementation::open() {
  if (stopped) return;
  opened_ns = client::monotonic_now_ns();
  if (facts.began_ns == 0) facts.began_ns = opened_ns;
  resolver.async_resolve(options.host, std::to_string(options.port),
                         [self = shared_from_this()](const error_code& error, const auto& found) {
                           self->facts.unknown_name = static_cast<bool>(error);
                           if (error) return self->open_again(error);
                           self->connect(found);
                         });
}

void DaemonLink::Implementation::connect(const Udp::resolver::results_type& found) {
  if (stopped) return;
  error_code error;
  for (const auto& each : found) {
    error_code ignored;
    socket.close(ignored);
    socket.open(each.endpoint().protocol(), error);
    if (!error) socket.connect(each.endpoint(), error);
    if (!error) break;
  }
  if (error) return open_again(error);
  error_code ignored;  // Less is not a fault: what does not fit is repeated.
  socket.set_option(Udp::socket::receive_buffer_size(kSocketBytes), ignored);
  socket.non_blocking(true, ignored);
  receive();
  poll();
}

void DaemonLink::Implementation::open_again(const error_code& error) {
  trouble(error);
  timer.expires_after(kOpenAgain);
  timer.async_wait([self = shared_from_this()](const error_code& cancelled) {
    if (!cancelled) self->open();
  });
}

void DaemonLink::Implementation::trouble(const error_code& error) {
  if (error == asio::error::operation_aborted || error == asio::error::would_block) return;
  facts.trouble = error.value();
  facts.trouble_text = error.message();
  facts.trouble_ns = client::monotonic_now_ns();
}

void DaemonLink::Implementation::send(std::span<const std::uint8_t> datagram) {
  error_code error;
  socket.send(asio::buffer(datagram.data(), datagram.size()), 0, error);
  if (error) trouble(error);
}

void DaemonLink::Implementation::receive() {
  socket.async_receive(asio::buffer(buffer),
                       [self = shared_from_this()](const error_code& error, std::size_t bytes) {
                         if (error == asio::error::operation_aborted || self->stopped) return;
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
  const std::span<const std::uint8_t> datagram(buffer.data(), bytes);
  if (bytes >= wire::kHeaderBytes && datagram[0] == 'H' && datagram[1] != wire::kWireMajor) {
    facts.other_major = datagram[1];
    facts.other_major_ns = now_ns;
  }
  const auto header = wire::decode_header(datagram);
  const std::int64_t heard_ns = core->heard_ns();
  const std::uint64_t ended_before = sessions_ended;
  core->receive(datagram, now_ns);
  const bool valid = core->heard_ns() == now_ns && heard_ns != now_ns;
  if (valid) {
    facts.heard_ns = now_ns;
    if (sessions_ended == ended_before) facts.full = facts.said_bye = false;
  } else if (sessions_ended != ended_before) {
    facts.heard_ns = now_ns;  // A Reset or another boot_id is a word of the daemon too.
  }
  meter.take(valid ? &*header : nullptr, bytes);
}

void DaemonLink::Implementation::poll() {
  if (stopped) return;
  const std::int64_t now_ns = client::monotonic_now_ns();
  const std::int64_t heard_ns = std::max(opened_ns, facts.heard_ns);
  if (now_ns - heard_ns > kOtherSocket_ns) {
    error_code ignored;
    socket.close(ignored);
    open();
    return;
  }
  core->poll(now_ns);
  wait();
}

void DaemonLink::Implementation::wait() {
  const std::int64_t until_due = core->due_ns() - client::monotonic_now_ns();
  timer.expires_after(
      std::chrono::nanoseconds(std::clamp<std::int64_t>(until_due, 0, kMaxWait_ns)));
  timer.async_wait([self = shared_from_this()](const error_code& cancelled) {
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
  if (mine.stopped) return;
  mine.stopped = true;
  mine.handlers = {};
  if (mine.socket.is_open()) {
    mine.core->leave(client::monotonic_now_ns());
    mine.core->poll(client::monotonic_now_ns());
  }
  error_code ignored;
  mine.socket.close(ignored);
  mine.resolver.cancel();
  mine.timer.cancel();
}

bool DaemonLink::request(const v1::Item& item, client::ResultHandler done) {
  if (verdict().state != v1::PAGE_LINK_STATE_LIVE) return false;
  if (implementation_->core->request(item, std::move(done)) == 0) return false;
  implementation_->poll();
  return true;
}

LinkVerdict DaemonLink::verdict() const {
  return judge(implementation_->facts, client::monotonic_now_ns());
}

v1::PageLink DaemonLink::report() {
  const std::int64_t now_ns = client::monotonic_now_ns();
  const LinkVerdict verdict = judge(implementation_->facts, now_ns);
  v1::PageLink link;
  link.set_state(verdict.state);
  link.set_message(verdict.message);
  const wire::ClockEstimate& clock = implementation_->core->clock();
  if (clock.known()) {
    const wire::ClockRelation relation = clock.at(now_ns);
    link.set_clock_offset_s(static_cast<double>(relation.offset_ns) * 1e-9);
    link.set_clock_error_s(static_cast<double>(relation.uncertainty_ns) * 1e-9);
    link.set_round_trip_s(static_cast<double>(clock.round_trip_ns()) * 1e-9);
  }
  const LinkQuality quality = implementation_->meter.roll(now_ns);
  link.set_loss(quality.loss);
  link.set_bytes_per_s(quality.bytes_per_s);
  return link;
}

std::int64_t DaemonLink::daemon_now_ns() const {
  const wire::ClockEstimate& clock = implementation_->core->clock();
  if (!clock.known()) return 0;
  const std::int64_t now_ns = client::monotonic_now_ns();
  return now_ns + clock.at(now_ns).offset_ns;
}

bool DaemonLink::may_control() const {
  const auto& key = implementation_->options.key;
  return !key.has_value() || key->role == wire::Role::kControl;
}

std::uint64_t DaemonLink::received_bytes() const { return implementation_->meter.total_bytes(); }

std::uint64_t DaemonLink::sessions_ended() const { return implementation_->sessions_ended; }

}  // namespace hapticd::web
