// What the gateway answers over HTTP, to browsers and to those who are none: heads that keep an
// answer what it is, files that are streamed and not held, places that nobody keeps by waiting.
#include <doctest/doctest.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>
#include <memory>
#include <vector>

#include "clients/web/gateway/checked_file.h"
#include "tests/clients/web/gateway/browser.h"
#include "tests/clients/web/gateway/fake_daemon.h"
#include "tests/clients/web/gateway/raw_peer.h"
#include "tests/clients/web/gateway/running_gateway.h"

namespace hapticd::test {
namespace {

namespace fs = std::filesystem;
namespace http = boost::beast::http;

/// A page, packed and not, and a folder of assets; both go with it.
struct Site {
  Site() {
    std::string name = (fs::temp_directory_path() / "hapticd_web_XXXXXX").string();
    REQUIRE(::mkdtemp(name.data()) != nullptr);
    root = name;
    fs::create_directories(root / "page" / "assets");
    fs::create_directories(root / "models");
    write("page/index.html", "<html>");
    write("page/index.html.gz", "packed");
    write("page/assets/app-1.js", "go()");
  }
  ~Site() { fs::remove_all(root); }
  Site(const Site&) = delete;
  Site& operator=(const Site&) = delete;
  void write(const std::string& name, const std::string& bytes) const {
    std::ofstream(root / name, std::ios::binary) << bytes;
  }
  [[nodiscard]] web::WebOptions options(std::uint16_t daemon) const {
    web::WebOptions made = options_for(daemon);
    made.server.page = root / "page";
    made.assets = {root / "models"};
    return made;
  }
  fs::path root;
};

/// Of a file in `site` that takes no place on the disk.
std::string hash_of_zeros(const Site& site, std::uintmax_t size) {
  site.write("models/large.ply", "");
  fs::resize_file(site.root / "models" / "large.ply", size);
  return web::OpenFile::at(site.root / "models" / "large.ply")->digest()->hash;
}

TEST_CASE("every answer says what a browser may do with it, also those to what is no request") {
  const Site site;
  FakeDaemon daemon;
  RunningGateway gateway(site.options(daemon.port()));
  const std::string port = std::to_string(gateway.port());
  const std::string end = "\r\nHost: 127.0.0.1:" + port + "\r\nConnection: close\r\n\r\n";
  const std::string shake =
      "GET /stream HTTP/1.1\r\nHost: 127.0.0.1:" + port +
      "\r\nUpgrade: websocket\r\nConnection: Upgrade\r\nSec-WebSocket-Version: 13\r\n"
      "Sec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==\r\n";
  const std::vector<std::pair<std::string, std::string>> asked{
      {"200", "GET / HTTP/1.1" + end},
      {"200", "GET /metrics HTTP/1.1" + end},
      {"200", "HEAD /assets/app-1.js HTTP/1.1" + end},
      {"404", "GET /nothing HTTP/1.1" + end},
      {"404", "GET /asset/../../etc/passwd HTTP/1.1" + end},
      {"404", "GET /%2e%2e/models HTTP/1.1" + end},
      {"405", "POST / HTTP/1.1" + end},
      {"421", "GET / HTTP/1.1\r\nHost: evil.example\r\n\r\n"},
      {"101", shake + "\r\n"},
      {"403", shake + "Origin: http://evil.example\r\n\r\n"},
      {"400", "nonsense\r\n\r\n"},
      {"400", std::string("GET /\0 HTTP/1.1", 15) + end},
      {"431", "GET / HTTP/1.1\r\nCookie: " + std::string(10'000, 'x') + "\r\n\r\n"}};
  for (const auto& [status, request] : asked) {
    const std::string begin = request.substr(0, 60);
    CAPTURE(begin);
    Peer peer(gateway.port());
    peer.say(request);
    const std::string head = peer.head();
    CAPTURE(head);
    CHECK(head.starts_with("HTTP/1.1 " + status + " "));
    CHECK(head.find("\r\nContent-Security-Policy: default-src 'none'; script-src 'self' "
                    "'wasm-unsafe-eval';") != head.npos);
    CHECK(head.find("frame-ancestors 'none'\r\n") != head.npos);
    CHECK(head.find("\r\nCross-Origin-Opener-Policy: same-origin\r\n") != head.npos);
    CHECK(head.find("\r\nX-Content-Type-Options: nosniff\r\n") != head.npos);
  }
}

TEST_CASE("the policy names the WebSocket by the host that was asked, and nothing but a host") {
  const Site site;
  FakeDaemon daemon;
  RunningGateway gateway(site.options(daemon.port()));
  const auto policy = [&](const std::string& host) {
    return std::string(fetch(gateway.port(), "/", host)["Content-Security-Policy"]);
  };
  CHECK(policy("localhost:81").find("connect-src 'self' ws://localhost:81 wss://localhost:81;") !=
        std::string::npos);
  CHECK(policy("[::1]:81").find(" ws://[::1]:81 ") != std::string::npos);
  const std::string foreign = policy("127.0.0.1:81; script-src *");
  CHECK(foreign.find("connect-src 'self';") != std::string::npos);
  CHECK(foreign.find('*') == std::string::npos);
}

TEST_CASE("a text is sent packed to who accepts that, and each form has a tag of its own") {
  const Site site;
  FakeDaemon daemon;
  RunningGateway gateway(site.options(daemon.port()));
  const auto ask = [&](const std::map<std::string, std::string>& heads) {
    return fetch(gateway.port(), "/", "127.0.0.1", http::verb::get, heads);
  };
  const auto plain = ask({});
  CHECK(plain.body() == "<html>");
  CHECK(plain[http::field::content_encoding].empty());
  CHECK(plain[http::field::vary] == "Accept-Encoding");
  const auto packed = ask({{"Accept-Encoding", "gzip, br"}});
  CHECK(packed.body() == "packed");
  CHECK(packed[http::field::content_encoding] == "gzip");
  CHECK(packed[http::field::vary] == "Accept-Encoding");
  CHECK(packed[http::field::content_type] == "text/html; charset=utf-8");
  const std::string tag(packed[http::field::etag]);
  CHECK(tag.size() == 66);
  CHECK(tag != plain[http::field::etag]);
  const auto same = ask({{"Accept-Encoding", "gzip"}, {"If-None-Match", "\"x\", W/" + tag}});
  CHECK(same.result_int() == 304);
  CHECK(same.body().empty());
  CHECK(same[http::field::etag] == tag);
  CHECK(ask({{"If-None-Match", tag}}).body() == "<html>");
  CHECK(ask({{"If-None-Match", "*"}}).result_int() == 304);
  CHECK(fetch(gateway.port(), "/assets/app-1.js")[http::field::vary].empty());
}

TEST_CASE("whatever range is asked for, the whole is sent") {
  const Site site;
  site.write("models/body.ply", "abc");
  FakeDaemon daemon;
  RunningGateway gateway(site.options(daemon.port()));
  const std::string asset = "/asset/" + web::hash_of("abc");
  for (const char* range : {"bytes=0-0", "bytes=-1", "bytes=5-2", "bytes=99999999999999999999-",
                            "bytes=0-1,0-1,0-1", "lines=1-2", "bytes="}) {
    CAPTURE(range);
    const auto answer =
        fetch(gateway.port(), asset, "127.0.0.1", http::verb::get, {{"Range", range}});
    CHECK(answer.result_int() == 200);
    CHECK(answer.body() == "abc");
    CHECK(answer[http::field::accept_ranges] == "none");
  }
}

TEST_CASE("40 slow readers of 60 MB make the gateway hold less than 20 MB, and nobody waits") {
  constexpr std::uintmax_t kSize = 60'000'000;
  constexpr std::size_t kMost = 20'000'000;
  const Site site;
  const std::string asset = "/asset/" + hash_of_zeros(site, kSize);
  FakeDaemon daemon;
  RunningGateway gateway(site.options(daemon.port()));
  REQUIRE(fetch(gateway.port(), asset, "127.0.0.1", http::verb::head).result_int() == 200);
  const std::size_t before = anonymous_bytes();
  std::vector<std::unique_ptr<Peer>> readers;
  for (int i = 0; i < 40; ++i) {
    readers.push_back(std::make_unique<Peer>(gateway.port(), 4096));
    readers.back()->say(get(asset));
  }
  for (const auto& reader : readers) {
    CHECK(reader->head().find("\r\nContent-Length: 60000000\r\n") != std::string::npos);
  }
  CHECK(fetch(gateway.port(), "/").body() == "<html>");
  const std::size_t after = anonymous_bytes();
  MESSAGE("held for 40 readers: ", after > before ? after - before : 0, " bytes");
  CHECK(after < before + kMost);
  // One that reads on gets all of it.
  CHECK(fetch(gateway.port(), asset).body().size() == kSize);
}

TEST_CASE("a file that is cut off while it is sent breaks off, and the gateway goes on") {
  const Site site;
  const std::string asset = "/asset/" + hash_of_zeros(site, 8'000'000);
  FakeDaemon daemon;
  RunningGateway gateway(site.options(daemon.port()));
  Peer reader(gateway.port(), 4096);
  reader.say(get(asset));
  CHECK(reader.head().starts_with("HTTP/1.1 200 "));
  fs::resize_file(site.root / "models" / "large.ply", 1000);
  CHECK(reader.body() < 8'000'000);
  CHECK(fetch(gateway.port(), asset).result_int() == 404);
  CHECK(fetch(gateway.port(), "/").body() == "<html>");
}

TEST_CASE("connections that only wait keep nobody out, in whatever they wait") {
  const Site site;
  FakeDaemon daemon;
  web::WebOptions options = site.options(daemon.port());
  options.server.most_connections = 8;
  const std::string asset = "/asset/" + hash_of_zeros(site, 8'000'000);
  RunningGateway gateway(options);
  std::vector<std::unique_ptr<Peer>> idle;
  for (int i = 0; i < 200; ++i) {
    idle.push_back(std::make_unique<Peer>(gateway.port(), 4096));
    if (i % 3 == 1) idle.back()->say("GET / HTTP/1.1\r\nHost: 127.");
    if (i % 3 == 2) idle.back()->say(get(asset));
  }
  CHECK(fetch(gateway.port(), "/").body() == "<html>");
  CHECK(Browser(gateway.port()).status() == 101);
}

TEST_CASE(
    "a page with the token always finds a place: the looker not heard for longest gives way") {
  const Site site;
  FakeDaemon daemon;
  web::WebOptions options = site.options(daemon.port());
  options.server.most_viewers = 4;
  RunningGateway gateway(options);
  std::vector<std::unique_ptr<Browser>> lookers;
  for (int i = 0; i < 3; ++i) lookers.push_back(std::make_unique<Browser>(gateway.port()));
  // The first says something after the others came, and is heard: its answer comes.
  for (const auto& looker : lookers) looker->next();
  v1::PageRequest list;
  list.mutable_list_recordings();
  CHECK(lookers[0]->ask(list).code() == v1::RESULT_CODE_NOT_PERMITTED);
  CHECK(Browser(gateway.port()).status() == 503);
  Browser first(gateway.port(), gateway.control());
  CHECK(first.next().welcome().control());
  Browser second(gateway.port(), gateway.control());
  CHECK(second.next().welcome().control());
  CHECK(lookers[1]->close_code() == 1013);
  CHECK(lookers[1]->close_words().find("needed this place") != std::string::npos);
  Browser third(gateway.port(), gateway.control());
  CHECK(lookers[2]->close_code() == 1013);
  CHECK(lookers[0]->ask(list).code() == v1::RESULT_CODE_NOT_PERMITTED);
  Browser fourth(gateway.port(), gateway.control());
  CHECK(lookers[0]->close_code() == 1013);
  // Pages with the token take no place from each other.
  CHECK(Browser(gateway.port(), gateway.control()).status() == 503);
  CHECK(fetch(gateway.port(), "/metrics").body().find("\nhaptic_web_viewers_gave_way_total 3\n") !=
        std::string::npos);
}

TEST_CASE("a looker that says nothing any more gives its place to another") {
  const Site site;
  FakeDaemon daemon;
  web::WebOptions options = site.options(daemon.port());
  options.server.most_viewers = 1;
  options.server.quiet = std::chrono::nanoseconds{0};
  RunningGateway gateway(options);
  Browser quiet(gateway.port());
  quiet.next();
  Browser other(gateway.port());
  CHECK(other.status() == 101);
  CHECK(quiet.close_code() == 1013);
}

}  // namespace
}  // namespace hapticd::test
