// See stop_road.h.
#include "clients/library/stop_road.h"

#include <netdb.h>
#include <netinet/in.h>
#include <poll.h>
#include <sodium.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstring>
#include <filesystem>
#include <system_error>
#include <utility>
#include <vector>

#include "clients/library/client.h"
#include "proto/noise/key_folder.h"

namespace hapticd::client {
namespace {

using stop::StopCall;
using stop::StopTarget;
using State = StopCall::State;

/// Time from one datagram to the next, ns.
constexpr std::int64_t kAgain_ns = 10'000'000;
/// How long a Stop that the daemon has is followed until its loop has latched it, ns.
constexpr std::int64_t kFollow_ns = 100'000'000;
/// Addresses of a name that are tried, all at once.
constexpr std::size_t kMostAddresses = 4;

std::uint64_t random_client() {
  std::uint64_t id = 0;
  while (id == 0) randombytes_buf(&id, sizeof(id));
  return id;
}

bool is_loopback(const addrinfo& found) {
  if (found.ai_family == AF_INET) {
    sockaddr_in v4{};
    std::memcpy(&v4, found.ai_addr, sizeof(v4));
    return ntohl(v4.sin_addr.s_addr) >> 24U == 127;
  }
  sockaddr_in6 v6{};
  std::memcpy(&v6, found.ai_addr, sizeof(v6));
  return IN6_IS_ADDR_LOOPBACK(&v6.sin6_addr) != 0;
}

/// A Stop on its way to one address.
class Errand {
 public:
  Errand(const addrinfo& to, const StopTarget& target)
      : socket_(::socket(to.ai_family, SOCK_DGRAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0)),
        call_(stop::Kind::kStop, target, random_client()) {
    deaf_ = socket_ < 0 || ::connect(socket_, to.ai_addr, to.ai_addrlen) != 0;
  }
  ~Errand() {
    if (socket_ >= 0) ::close(socket_);
  }
  Errand(Errand&& other) noexcept
      : socket_(std::exchange(other.socket_, -1)),
        call_(std::move(other.call_)),
        deaf_(other.deaf_) {}
  Errand& operator=(Errand&&) = delete;
  Errand(const Errand&) = delete;
  Errand& operator=(const Errand&) = delete;

  void send() {
    if (over()) return;
    const stop::Datagram datagram = call_.next();
    if (::send(socket_, datagram.data(), datagram.size(), MSG_NOSIGNAL) < 0) hear_error();
  }
  /// Takes what has come; true when there is something new to say at once.
  bool receive() {
    const bool asked = call_.asked();
    bool heard = false;
    while (!over()) {
      std::array<std::uint8_t, stop::kDatagramBytes + 1> bytes;
      const ssize_t came = ::recv(socket_, bytes.data(), bytes.size(), 0);
      if (came < 0) {
        hear_error();
        break;
      }
      heard = call_.receive({bytes.data(), static_cast<std::size_t>(came)}) || heard;
    }
    return heard && !asked && call_.state() == State::kAsking && !call_.asked();
  }

  [[nodiscard]] int socket() const noexcept { return socket_; }
  [[nodiscard]] const StopCall& call() const noexcept { return call_; }
  /// Nothing more will come of it.
  [[nodiscard]] bool over() const noexcept { return deaf_ || call_.state() != State::kAsking; }

 private:
  void hear_error() {
    // Nobody is at that port, or there is no way there.
    if (errno != EAGAIN && errno != EWOULDBLOCK && errno != EINTR && errno != ENOBUFS) deaf_ = true;
  }

  int socket_;
  StopCall call_;
  bool deaf_ = false;
};

std::vector<Errand> errands_to(const StopPlace& place) {
  addrinfo wanted{};
  wanted.ai_socktype = SOCK_DGRAM;
  addrinfo* found = nullptr;
  std::vector<Errand> errands;
  if (::getaddrinfo(place.host.c_str(), std::to_string(place.port).c_str(), &wanted, &found) != 0) {
    return errands;
  }
  for (const addrinfo* each = found; each != nullptr; each = each->ai_next) {
    const bool heard = place.target.key.has_value() || is_loopback(*each);
    if (heard && errands.size() < kMostAddresses) errands.emplace_back(*each, place.target);
  }
  ::freeaddrinfo(found);
  return errands;
}

void wait_for(const std::vector<Errand>& errands, std::int64_t until_ns) {
  std::array<pollfd, kMostAddresses> watched{};
  nfds_t count = 0;
  for (const Errand& errand : errands) {
    if (!errand.over()) watched.at(count++) = {errand.socket(), POLLIN, 0};
  }
  const std::int64_t wait_ns = std::max<std::int64_t>(0, until_ns - monotonic_now_ns());
  ::poll(watched.data(), count, static_cast<int>((wait_ns + 999'999) / 1'000'000));
}

std::string reason(const std::vector<Errand>& errands, const StopPlace& place) {
  const std::string there = "at " + place.host + ", port " + std::to_string(place.port);
  if (errands.empty() && !place.target.key) {
    return "a Stop road beyond this machine needs stop.key: give it with --stop-key FILE";
  }
  const auto any = [&](State state) {
    return std::any_of(errands.begin(), errands.end(),
                       [state](const Errand& errand) { return errand.call().state() == state; });
  };
  if (any(State::kOtherDaemon)) return "the Stop road " + there + " is another daemon's";
  if (any(State::kRefused)) return "the Stop road " + there + " refuses";
  return "no Stop road answers " + there;
}

}  // namespace

StopReport stop_by_road(const StopPlace& place, std::chrono::nanoseconds patience) {
  StopReport report;
  if (sodium_init() < 0) {
    report.why = "libsodium does not start";
    return report;
  }
  std::vector<Errand> errands = errands_to(place);
  const std::int64_t begun_ns = monotonic_now_ns();
  std::int64_t end_ns = begun_ns + patience.count();
  std::int64_t due_ns = begun_ns;
  const auto open = [](const Errand& errand) { return !errand.over(); };
  while (!report.latched && std::any_of(errands.begin(), errands.end(), open)) {
    const std::int64_t now_ns = monotonic_now_ns();
    if (now_ns >= end_ns) break;
    if (now_ns >= due_ns) {
      for (Errand& errand : errands) errand.send();
      due_ns = now_ns + kAgain_ns;
    }
    wait_for(errands, std::min(due_ns, end_ns));
    for (Errand& errand : errands) {
      if (errand.receive()) errand.send();
      if (errand.call().asked() && !report.stopped) {
        report.stopped = true;
        end_ns = std::min(end_ns, monotonic_now_ns() + kFollow_ns);
        due_ns = monotonic_now_ns() + 2'000'000;
      }
      report.latched = report.latched || errand.call().state() == State::kDone;
    }
  }
  if (!report.stopped) report.why = reason(errands, place);
  return report;
}

std::optional<stop::SecretKey> named_stop_key(const std::string& file,
                                              const std::string& key_file) {
  if (!file.empty()) return noise::read_bare_key(file);
  if (key_file.empty()) return std::nullopt;
  const auto beside = std::filesystem::path(key_file).parent_path() / noise::kStopKeyName;
  std::error_code unknown;
  if (!std::filesystem::exists(std::filesystem::symlink_status(beside, unknown))) {
    return std::nullopt;
  }
  return noise::read_bare_key(beside);
}

}  // namespace hapticd::client
