// The client that check_client.py checks: opens a session of the C++ library, asks for States, and
// pings until it is ended, 20 s at most. Usage: asking_client HOST:PORT
#include <chrono>
#include <cstdio>
#include <exception>
#include <string>

#include "clients/library/client.h"

namespace {

constexpr std::chrono::milliseconds kPatience{500};
constexpr std::chrono::milliseconds kPause{50};

void ask(const std::string& address) {
  const std::size_t colon = address.rfind(':');
  const auto port = static_cast<std::uint16_t>(std::stoul(address.substr(colon + 1)));
  hapticd::client::Client client(address.substr(0, colon), port);
  hapticd::v1::Item ping;
  ping.mutable_ping();
  const auto end = std::chrono::steady_clock::now() + std::chrono::seconds(20);
  bool subscribed = false;
  while (std::chrono::steady_clock::now() < end) {
    hapticd::v1::Item subscribe;
    subscribe.mutable_subscribe()->set_divisor(10);
    const hapticd::v1::Result result = client.call(subscribed ? ping : subscribe, kPatience);
    subscribed = subscribed || result.code() == hapticd::v1::RESULT_CODE_OK;
    const auto next = std::chrono::steady_clock::now() + kPause;
    while (std::chrono::steady_clock::now() < next) client.poll(std::chrono::milliseconds(5));
  }
}

}  // namespace

int main(int argc, char** argv) {
  if (argc != 2) {
    std::fprintf(stderr, "usage: asking_client HOST:PORT\n");
    return 2;
  }
  try {
    ask(argv[1]);
  } catch (const std::exception& error) {
    std::fprintf(stderr, "asking_client: %s\n", error.what());
    return 1;
  }
  return 0;
}
