// Client and Controller against a server on a real socket of loopback.
#include "clients/library/client.h"

#include <doctest/doctest.h>

#include <fstream>
#include <iterator>
#include <optional>
#include <string>

#include "clients/library/controller.h"
#include "tests/clients/library/example.h"
#include "tests/clients/library/real_server.h"

namespace hapticd::test {
namespace {

using client::Client;
using client::Controller;

std::string text_of(const std::string& path) {
  std::ifstream file(std::string(HAPTICD_SOURCE_DIR) + "/" + path);
  REQUIRE(file.good());
  return {std::istreambuf_iterator<char>(file), std::istreambuf_iterator<char>()};
}

TEST_CASE("the program in the README is compiled as it stands, and runs") {
  const std::string readme = text_of("clients/library/README.md");
  const std::string opening = "```cpp\n";
  const std::size_t begin = readme.find(opening) + opening.size();
  const std::string program = readme.substr(begin, readme.find("```", begin) - begin);
  CHECK(program.size() > 500);
  CHECK(text_of("tests/clients/library/example.cpp").find(program) != std::string::npos);
  RealServer server;
  CHECK(example(server.port()) == 0);
  CHECK(server.poses == 100);
}

TEST_CASE("a Run of steps delivers every State to the client that runs it") {
  RealServer server;
  std::vector<std::uint64_t> ticks;
  client::ClientHandlers handlers;
  handlers.state = [&](const v1::State& state) { ticks.push_back(state.tick()); };
  Client client("127.0.0.1", server.port(), handlers);
  REQUIRE(client.connect());
  REQUIRE(client.subscribe(1).code() == v1::RESULT_CODE_OK);
  Controller controller(client);
  REQUIRE(controller.acquire("test").code() == v1::RESULT_CODE_OK);
  CHECK(controller.holds());
  const v1::Result result = controller.run(1000);
  CHECK(result.code() == v1::RESULT_CODE_OK);
  CHECK(result.run().steps() == 1000);
  CHECK(client.poll_until([&] { return ticks.size() >= 1000; }));
  for (std::size_t i = 0; i < ticks.size(); ++i) CHECK(ticks[i] == i);
  CHECK(controller.release().code() == v1::RESULT_CODE_OK);
  CHECK(client.poll_until([&] { return !controller.holds(); }));
}

TEST_CASE("a client waits for a server that is not there yet") {
  std::optional<RealServer> server;
  server.emplace();
  const std::uint16_t port = server->port();
  server.reset();
  Client client("127.0.0.1", port);
  v1::Item ping;
  ping.mutable_ping();
  const v1::Result none = client.call(ping, std::chrono::milliseconds(20));
  CHECK(none.code() == v1::RESULT_CODE_UNSPECIFIED);
  CHECK(none.message().find("is hapticd running") != std::string::npos);
  server.emplace(port);
  CHECK(client.connect());
  CHECK(client.call(ping).code() == v1::RESULT_CODE_OK);
}

TEST_CASE("a client begins anew with a server that was restarted") {
  std::optional<RealServer> server;
  server.emplace(std::uint16_t{0}, 1U);
  const std::uint16_t port = server->port();
  std::vector<client::SessionEnd> ends;
  client::ClientHandlers handlers;
  handlers.ended = [&](client::SessionEnd how) { ends.push_back(how); };
  Client client("127.0.0.1", port, handlers);
  REQUIRE(client.connect());
  const std::uint32_t before = client.core().session();
  server.reset();
  server.emplace(port, 2U);
  CHECK(client.poll_until([&] { return !ends.empty(); }));
  CHECK(ends.front() == client::SessionEnd::kForgotten);
  CHECK(client.connect());
  CHECK(client.core().session() != before);
  CHECK(client.core().boot_id() == 2);
}

TEST_CASE("a server that ends tells its clients, and a client that leaves its server") {
  RealServer server;
  std::vector<client::SessionEnd> ends;
  client::ClientHandlers handlers;
  handlers.ended = [&](client::SessionEnd how) { ends.push_back(how); };
  Client first("127.0.0.1", server.port(), handlers);
  Client second("127.0.0.1", server.port());
  REQUIRE(first.connect());
  REQUIRE(second.connect());
  second.leave();
  CHECK(second.core().over());
  server.say_bye = true;
  CHECK(first.poll_until([&] { return !ends.empty(); }));
  CHECK(ends.front() == client::SessionEnd::kBye);
  CHECK(first.core().bye().reason() == v1::BYE_REASON_SHUTDOWN);
  CHECK(first.core().bye().message() == "the end");
}

TEST_CASE("a host that does not exist is refused with its name") {
  CHECK_THROWS_WITH_AS(Client("no-such-host.invalid"), doctest::Contains("no-such-host.invalid"),
                       std::runtime_error);
}

}  // namespace
}  // namespace hapticd::test
