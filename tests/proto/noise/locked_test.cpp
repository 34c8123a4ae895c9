// Where secrets are, judged by what the kernel says of the page: /proc/self/smaps.
#include "proto/noise/locked.h"

#include <doctest/doctest.h>

#include <array>
#include <cstdint>
#include <fstream>
#include <sstream>
#include <stdexcept>
#include <string>

namespace hapticd::noise {
namespace {

using Value = std::array<std::uint8_t, 32>;

/// VmFlags of the mapping that holds `address`; empty: there is none.
std::string flags_of(const void* address) {
  std::ifstream maps("/proc/self/smaps");
  const auto wanted = reinterpret_cast<std::uintptr_t>(address);
  bool inside = false;
  for (std::string line; std::getline(maps, line);) {
    std::uintptr_t first = 0;
    std::uintptr_t end = 0;
    char dash = 0;
    std::istringstream range(line);
    if (range >> std::hex >> first >> dash >> end && dash == '-') {
      inside = first <= wanted && wanted < end;
    }
    if (inside && line.starts_with("VmFlags:")) return line + ' ';
  }
  return {};
}

TEST_CASE("a secret is in no core dump, is not swapped out, and nobody writes to it") {
  const auto secret = Locked<Value>::filled([](Value& value) { value.fill(7); });
  const std::string flags = flags_of(&secret.get());
  CAPTURE(flags);
  CHECK(flags.find(" dd ") != std::string::npos);
#ifndef HAPTICD_WITHOUT_MLOCK
  CHECK(flags.find(" lo ") != std::string::npos);
#endif
  CHECK(flags.find(" wr ") == std::string::npos);
}

TEST_CASE("copies share a secret, and it goes with the last of them") {
  auto first = std::make_unique<Locked<Value>>(Value{1, 2, 3});
  const void* address = &first->get();
  auto second = std::make_unique<Locked<Value>>(*first);
  CHECK(&second->get() == address);
  first.reset();
  CHECK(second->get()[2] == 3);
  CHECK(*second == Locked<Value>(Value{1, 2, 3}));
  CHECK(!(*second == Locked<Value>()));
  second.reset();
  CHECK(flags_of(address).empty());
}

TEST_CASE("a secret that cannot be filled is none") {
  CHECK_THROWS_AS((void)Locked<Value>::filled([](Value&) { throw std::runtime_error("no"); }),
                  std::runtime_error);
}

}  // namespace
}  // namespace hapticd::noise
