// The writer thread against a device that can be made to block or fail. Truth: what the device got.
#include "device/report_io/report_writer.h"

#include <doctest/doctest.h>

#include <algorithm>
#include <condition_variable>
#include <optional>
#include <thread>
#include <vector>

#include "tests/support/no_heap.h"
#include "tests/support/scale.h"

namespace hapticd::test {
namespace {

std::atomic<std::int64_t> clock_ns{0};
std::int64_t clock() noexcept { return clock_ns; }

/// Keeps the first byte behind the ID of each report it is given.
class Device {
 public:
  ReportChannel channel() { return {nullptr, this, nullptr, write, nullptr, nullptr}; }

  /// Waits until it was given so many reports; what they were.
  std::vector<int> given(std::size_t count) {
    std::unique_lock lock(mutex_);
    changed_.wait(lock, [&] { return given_.size() >= count; });
    return given_;
  }
  /// Waits until it was given this one; what it was given until then.
  std::vector<int> given_until(int number) {
    std::unique_lock lock(mutex_);
    changed_.wait(lock, [&] { return !given_.empty() && given_.back() == number; });
    return given_;
  }
  /// Waits until a write has begun that has not ended.
  void wait_until_inside() {
    std::unique_lock lock(mutex_);
    changed_.wait(lock, [&] { return inside_; });
  }
  void set_blocked(bool blocked) {
    const std::lock_guard lock(mutex_);
    blocked_ = blocked;
    changed_.notify_all();
  }
  void set_failing(bool failing) {
    const std::lock_guard lock(mutex_);
    failing_ = failing;
  }

 private:
  static int write(void* device, const std::uint8_t* bytes, std::size_t length) noexcept {
    auto& self = *static_cast<Device*>(device);
    std::unique_lock lock(self.mutex_);
    self.inside_ = true;
    self.changed_.notify_all();
    self.changed_.wait(lock, [&] { return !self.blocked_; });
    self.inside_ = false;
    self.given_.push_back(bytes[1]);
    self.changed_.notify_all();
    return self.failing_ ? -1 : static_cast<int>(length);
  }

  std::mutex mutex_;
  std::condition_variable changed_;
  std::vector<int> given_;
  bool blocked_ = false, failing_ = false, inside_ = false;
};

OutputReport report(int number) {
  OutputReport made;
  made.bytes = {2, static_cast<std::uint8_t>(number)};
  made.length = 2;
  return made;
}

/// Command `number`, instead of which 100 more is sent.
PostedCommand command(int number, std::int64_t posted_ns, std::uint32_t attachment = 1) {
  PostedCommand made;
  made.reports.push_back(report(number));
  made.instead.push_back(report(100 + number));
  made.posted_ns = posted_ns;
  made.attachment = attachment;
  return made;
}

struct Writing {
  Writing() {
    clock_ns = 0;
    writer.attach(device.channel(), 1);
  }
  Device device;
  ReportWriter writer{clock};
};

using Given = std::vector<int>;

}  // namespace

TEST_CASE("every command that is posted after the one before was sent is sent, in order") {
  Writing w;
  for (int k = 1; k <= 20; ++k) {
    w.writer.post(command(k, k));
    CHECK(w.device.given(static_cast<std::size_t>(k)).back() == k);
  }
}

TEST_CASE(
    "while a device blocks, the loop posts on, hears of it after 5 ms, and only the newest is "
    "sent") {
  Writing w;
  w.device.set_blocked(true);
  CHECK_FALSE(w.writer.stuck(0));
  w.writer.post(command(1, 1));
  w.device.wait_until_inside();
  for (int k = 2; k <= 9; ++k) {
    const std::int64_t now_ns = std::int64_t{1'000'000} * k;
    CAPTURE(k);
    CHECK(w.writer.stuck(now_ns) == (k >= 6));
    w.writer.post(command(k, now_ns));
  }
  w.device.set_blocked(false);
  CHECK(w.device.given(2) == Given{1, 9});
}

TEST_CASE("a device that takes each command late, but takes it, is not stuck") {
  Writing w;
  for (int k = 1; k <= 30; ++k) {
    w.device.set_blocked(true);
    w.writer.post(command(k, std::int64_t{4'000'000} * k));
    w.device.wait_until_inside();
    CHECK_FALSE(w.writer.stuck(std::int64_t{4'000'000} * k));
    w.device.set_blocked(false);
    w.device.given(static_cast<std::size_t>(k));
  }
}

TEST_CASE("a command that has expired when its turn comes is sent as no force") {
  Writing w;
  w.device.set_blocked(true);
  w.writer.post(command(1, 1));
  w.device.wait_until_inside();
  PostedCommand late = command(2, 2);
  late.expires_ns = 50;
  w.writer.post(late);
  clock_ns = 50;
  w.device.set_blocked(false);
  CHECK(w.device.given(2) == Given{1, 102});
}

TEST_CASE("what is revoked is replaced, sent or not, and a later command counts again") {
  Writing w;
  w.writer.post(command(1, 10));
  CHECK(w.device.given(1) == Given{1});
  w.writer.revoke(10);
  CHECK(w.device.given(2) == Given{1, 101});
  w.writer.post(command(2, 10));
  CHECK(w.device.given(3) == Given{1, 101, 102});
  w.writer.post(command(3, 11));
  CHECK(w.device.given(4) == Given{1, 101, 102, 3});
}

TEST_CASE("a refused command is told, and everything after it waits for another channel") {
  Writing w;
  w.device.set_failing(true);
  w.writer.post(command(1, 1));
  w.device.given(1);
  while (!w.writer.failed()) std::this_thread::yield();
  w.writer.post(command(2, 2));
  w.device.set_failing(false);
  w.writer.attach(w.device.channel(), 2);
  CHECK_FALSE(w.writer.failed());
  w.writer.post(command(3, 3, 2));
  CHECK(w.device.given(2).back() == 3);
}

TEST_CASE(
    "a device that was detached is given nothing, and the next one only what was made for it") {
  Writing w;
  w.writer.post(command(1, 1));
  w.device.given_until(1);
  w.writer.detach();
  Device other;
  w.writer.post(command(2, 2));
  w.writer.attach(other.channel(), 2);
  w.writer.post(command(3, 3));
  w.writer.revoke(3);
  w.writer.post(command(4, 4, 2));
  CHECK(other.given_until(4) == Given{4});
  CHECK(w.device.given(1) == Given{1});
  w.writer.detach();
}

TEST_CASE("the loop's side of the writer leaves the heap alone") {
  Writing w;
  const PostedCommand posted = command(1, 1);
  const NoHeapScope scope;
  w.writer.post(posted);
  const bool stuck = w.writer.stuck(2);
  w.writer.revoke(2);
  const std::int64_t touched = scope.count();
  CHECK(touched == 0);
  CHECK_FALSE(stuck);
}

TEST_CASE("a number goes up by one with each command that goes out, over its wrap, and names it") {
  struct Counting {
    std::atomic<std::int64_t> commands{0};
    std::uint16_t last = 0;
    std::int64_t wrong = 0;
  } device;
  ReportChannel channel;
  channel.output = &device;
  channel.write = [](void* output, const std::uint8_t* bytes, std::size_t length) noexcept -> int {
    auto& self = *static_cast<Counting*>(output);
    const auto number = static_cast<std::uint16_t>(bytes[2] | bytes[3] << 8);
    self.wrong += number == static_cast<std::uint16_t>(self.last + 1) ? 0 : 1;
    self.last = number;
    self.commands.fetch_add(1);
    return static_cast<int>(length);
  };
  clock_ns = 0;
  ReportWriter writer(clock);
  writer.attach(channel, 1);
  std::int64_t posts = 0;
  const auto post = [&](bool expired) {
    PostedCommand made = command(1, ++posts);
    made.reports[0].length = made.instead[0].length = 4;
    made.number_at = 2;
    made.tag = static_cast<std::uint64_t>(7 * posts);
    if (expired) made.expires_ns = 0;
    const std::int64_t before = device.commands.load();
    writer.post(made);
    while (device.commands.load() == before) std::this_thread::yield();
  };
  for (std::int64_t k = 0; k < std::max<std::int64_t>(scaled(70'000), 300); ++k) {
    post(k % 5 == 4);
    const std::optional<std::uint64_t> tag = writer.sent(device.last);
    if (k % 5 == 4) {
      REQUIRE_FALSE(tag.has_value());
    } else {
      REQUIRE(tag.has_value());
      REQUIRE(*tag == static_cast<std::uint64_t>(7 * posts));
    }
  }
  CHECK(device.wrong == 0);
  // What takes the force back is a command too, but none that was posted.
  writer.revoke(posts);
  while (device.commands.load() == posts) std::this_thread::yield();
  CHECK(device.wrong == 0);
  CHECK_FALSE(writer.sent(device.last).has_value());
  // A number that was not yet given, one that is forgotten, and one of another attachment.
  CHECK_FALSE(writer.sent(static_cast<std::uint16_t>(device.last + 1)).has_value());
  CHECK_FALSE(writer.sent(static_cast<std::uint16_t>(device.last - kNumberedCommands)).has_value());
  const auto own = static_cast<std::uint16_t>(device.last - 2);
  CHECK(writer.sent(own).has_value());
  writer.attach(channel, 2);
  CHECK_FALSE(writer.sent(own).has_value());
}

}  // namespace hapticd::test
