// See client.h.
#include "clients/library/client.h"

#include <netdb.h>
#include <poll.h>
#include <sys/random.h>
#include <sys/socket.h>
#include <time.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <stdexcept>
#include <system_error>
#include <utility>

namespace hapticd::client {
namespace {

/// The longest wait between two looks at what is due.
constexpr std::chrono::milliseconds kMaxWait{10};
/// Datagrams taken before what is due is sent again.
constexpr int kMaxPerTurn = 64;
constexpr std::size_t kBufferBytes = 2048;
constexpr int kSocketBytes = 1 << 20;

std::uint32_t random_number() {
  std::uint32_t number = 0;
  if (getrandom(&number, sizeof number, 0) != static_cast<ssize_t>(sizeof number)) {
    throw std::runtime_error("the system provides no random numbers");
  }
  return number;
}

int connected_socket(const std::string& host, std::uint16_t port) {
  addrinfo hints{};
  hints.ai_family = AF_UNSPEC;
  hints.ai_socktype = SOCK_DGRAM;
  addrinfo* found = nullptr;
  const int error = getaddrinfo(host.c_str(), std::to_string(port).c_str(), &hints, &found);
  if (error != 0) {
    throw std::runtime_error("cannot find '" + host + "': " + gai_strerror(error));
  }
  const std::unique_ptr<addrinfo, void (*)(addrinfo*)> owner(found, freeaddrinfo);
  for (const addrinfo* each = found; each != nullptr; each = each->ai_next) {
    const int fd = ::socket(each->ai_family, SOCK_DGRAM | SOCK_NONBLOCK | SOCK_CLOEXEC, 0);
    if (fd < 0) continue;
    if (::connect(fd, each->ai_addr, each->ai_addrlen) == 0) {
      // Less is not a fault: what does not fit is repeated.
      setsockopt(fd, SOL_SOCKET, SO_RCVBUF, &kSocketBytes, sizeof kSocketBytes);
      return fd;
    }
    ::close(fd);
  }
  throw std::runtime_error("no socket to '" + host + "': " + std::system_category().message(errno));
}

v1::Result no_result(const std::string& message) {
  v1::Result result;
  result.set_message(message);
  return result;
}

}  // namespace

std::int64_t monotonic_now_ns() {
  timespec now{};
  clock_gettime(CLOCK_MONOTONIC, &now);
  return std::int64_t{now.tv_sec} * 1'000'000'000 + now.tv_nsec;
}

Client::Client(const std::string& host, std::uint16_t port, ClientHandlers handlers,
               std::optional<ClientKey> key)
    : server_((host.find(':') == std::string::npos ? host : "[" + host + "]") + ":" +
              std::to_string(port)),
      socket_(connected_socket(host, port)) {
  core_ = std::make_unique<ClientCore>(
      [this](std::span<const std::uint8_t> datagram) {
        // What the system does not take is lost, as on any network.
        (void)::send(socket_, datagram.data(), datagram.size(), MSG_NOSIGNAL);
      },
      random_number, wrapped(std::move(handlers)), key);
}

Client::~Client() {
  core_->leave(monotonic_now_ns());
  core_->poll(monotonic_now_ns());
  ::close(socket_);
}

ClientHandlers Client::wrapped(ClientHandlers handlers) {
  ClientHandlers all = handlers;
  all.item = [this, then = std::move(handlers.item)](const v1::Item& item) {
    if (item.has_scene_info()) scene_ = item.scene_info();
    if (item.has_lease_info()) lease_ = item.lease_info();
    if (then) then(item);
  };
  all.state = [this, then = std::move(handlers.state)](const v1::State& state) {
    state_ = state;
    if (then) then(state);
  };
  all.ended = [this, then = std::move(handlers.ended)](SessionEnd how) {
    state_.reset();
    scene_.reset();
    lease_.Clear();
    if (then) then(how);
  };
  return all;
}

void Client::poll(std::chrono::nanoseconds wait) {
  core_->poll(monotonic_now_ns());
  const std::int64_t until_due = core_->due_ns() - monotonic_now_ns();
  const std::int64_t nanoseconds =
      std::clamp<std::int64_t>(std::min<std::int64_t>(wait.count(), until_due), 0,
                               std::chrono::nanoseconds(kMaxWait).count());
  const timespec timeout{0, static_cast<long>(nanoseconds)};
  pollfd wanted{socket_, POLLIN, 0};
  if (ppoll(&wanted, 1, &timeout, nullptr) > 0) {
    std::array<std::uint8_t, kBufferBytes> buffer{};
    for (int i = 0; i < kMaxPerTurn; ++i) {
      const ssize_t bytes = ::recv(socket_, buffer.data(), buffer.size(), 0);
      if (bytes < 0) break;  // Empty, or nothing listens there yet.
      core_->receive({buffer.data(), static_cast<std::size_t>(bytes)}, monotonic_now_ns());
    }
  }
  core_->poll(monotonic_now_ns());
}

bool Client::connect(std::chrono::nanoseconds timeout) {
  return poll_until([this] { return scene_.has_value(); }, timeout);
}

v1::Result Client::call(const v1::Item& request, std::chrono::nanoseconds timeout) {
  // On the heap: the Result may come after this function gave up.
  const auto answer = std::make_shared<std::optional<v1::Result>>();
  const std::uint64_t id = core_->request(request, [answer](const v1::Result* result) {
    *answer = result != nullptr ? *result : no_result("the session ended before the Result came");
  });
  if (id == 0) return no_result("the session is ending");
  if (poll_until([&] { return answer->has_value(); }, timeout)) return **answer;
  return no_result("no Result in time from " + server_ +
                   (core_->heard() ? "" : ": is hapticd running there?"));
}

std::uint64_t Client::request(const v1::Item& request, ResultHandler done) {
  return core_->request(request, std::move(done));
}

v1::Result Client::subscribe(std::uint32_t divisor, const std::vector<v1::Section>& sections) {
  v1::Item item;
  item.mutable_subscribe()->set_divisor(divisor);
  for (const v1::Section section : sections) item.mutable_subscribe()->add_sections(section);
  return call(item);
}

void Client::leave() {
  core_->leave(monotonic_now_ns());
  poll_until([this] { return core_->over(); });
}

}  // namespace hapticd::client
