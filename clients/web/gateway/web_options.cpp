// See web_options.h.
#include "clients/web/gateway/web_options.h"

#include <CLI/CLI.hpp>
#include <charconv>
#include <cstdio>
#include <cstdlib>
#include <stdexcept>
#include <utility>

namespace hapticd::web {
namespace {

namespace fs = std::filesystem;

/// What is given as text, until it is looked at as a whole.
struct Texts {
  std::string server = "127.0.0.1:47800";
  std::string listen = "127.0.0.1:8080";
  std::string key_file;
  std::string role;
};

/// Where the installed files are: HAPTICD_DATA, else ../share/hapticd from the program.
fs::path data_folder() {
  if (const char* given = std::getenv("HAPTICD_DATA")) return given;
  std::error_code unknown;
  return fs::read_symlink("/proc/self/exe", unknown).parent_path().parent_path() / "share" /
         "hapticd";
}

/// HOST:PORT, HOST, [V6]:PORT or :PORT, the rest as it was. Throws CLI::ValidationError.
void read_endpoint(const std::string& option, const std::string& text, bool zero_port,
                   std::string& host, std::uint16_t& port) {
  const auto bad = [&] {
    return CLI::ValidationError(option, "'" + text + "' is not HOST, HOST:PORT or [V6]:PORT");
  };
  std::string rest = text;
  if (rest.starts_with('[')) {
    const std::size_t end = rest.find(']');
    if (end == std::string::npos) throw bad();
    host = rest.substr(1, end - 1);
    rest = rest.substr(end + 1);
  } else if (const std::size_t colon = rest.find(':'); colon == rest.rfind(':')) {
    if (colon != 0) host = rest.substr(0, colon);
    rest = colon == std::string::npos ? "" : rest.substr(colon);
  } else {
    host = std::exchange(rest, "");  // an IPv6 address alone
  }
  if (rest.empty()) return;
  int number = 0;
  const char* end = rest.data() + rest.size();
  const auto read = std::from_chars(rest.data() + 1, end, number);
  if (rest[0] != ':' || read.ptr != end || read.ec != std::errc{} || number < (zero_port ? 0 : 1) ||
      number > 65535) {
    throw bad();
  }
  port = static_cast<std::uint16_t>(number);
}

void add_options(CLI::App& app, Texts& texts, WebOptions& options) {
  app.set_version_flag("--version", "haptic-web " HAPTICD_VERSION);
  app.add_option("--server", texts.server, "where hapticd listens, HOST:PORT")
      ->capture_default_str();
  app.add_option("--key", texts.key_file, "key of a hapticd that has keys")->type_name("FILE");
  app.add_option("--role", texts.role, "whose key it is (control, unless it is called view.key)")
      ->check(CLI::IsMember({"view", "control"}))
      ->type_name("view|control");
  app.add_option("--listen", texts.listen, "where browsers connect, ADDR:PORT; port 0: any")
      ->capture_default_str();
  auto* certificate = app.add_option("--cert", options.server.certificate,
                                     "certificate in PEM form; browsers connect by https then")
                          ->type_name("FILE");
  auto* private_key =
      app.add_option("--key-file", options.server.private_key, "key of the certificate")
          ->type_name("FILE");
  certificate->needs(private_key);
  private_key->needs(certificate);
  app.add_option("--name", options.server.names,
                 "name of this machine that browsers may use, beside its addresses; repeatable")
      ->type_name("NAME");
  app.add_option("--page", options.server.page, "folder of the page (default: the installed one)")
      ->type_name("DIR");
  app.add_option("--assets", options.assets,
                 "folder of meshes and trees, beside the installed ones; repeatable")
      ->type_name("DIR");
  app.add_option("--replay", options.recording, "plays this recording instead of a daemon")
      ->type_name("FILE");
  app.add_option("--rate", options.link.state_rate_hz, "States asked for, 1/s")
      ->check(CLI::Range(1.0, 1000.0))
      ->capture_default_str();
  app.add_option("--delay", options.presentation_delay_s,
                 "delay at which pages present what happened, s")
      ->check(CLI::Range(0.0, 1.0))
      ->capture_default_str();
  app.add_option("--viewers", options.server.most_viewers, "most viewers at once")
      ->check(CLI::Range(1, 10000))
      ->capture_default_str();
}

void finish(const Texts& texts, WebOptions& options) {
  read_endpoint("--server", texts.server, false, options.link.host, options.link.port);
  read_endpoint("--listen", texts.listen, true, options.server.address, options.server.port);
  if (options.server.page.empty()) options.server.page = data_folder() / "web";
  options.assets.push_back(data_folder() / "models");
  options.server.most_connections = options.server.most_viewers + 192;
  if (texts.key_file.empty()) return;
  std::optional<wire::Role> role;
  if (texts.role == "view") role = wire::Role::kView;
  if (texts.role == "control") role = wire::Role::kControl;
  options.link.key = client::read_client_key(texts.key_file, role);
}

}  // namespace

ParsedOptions parse_options(int argc, const char* const* argv) {
  CLI::App app("Shows a running hapticd, or a recording, in browsers.", "haptic-web");
  Texts texts;
  ParsedOptions parsed;
  add_options(app, texts, parsed.options);
  try {
    app.parse(argc, argv);
    finish(texts, parsed.options);
  } catch (const CLI::ParseError& error) {
    parsed.exit_code = app.exit(error) == 0 ? 0 : 2;
  } catch (const std::runtime_error& error) {
    std::fprintf(stderr, "haptic-web: --key: %s\n", error.what());
    parsed.exit_code = 1;
  }
  return parsed;
}

}  // namespace hapticd::web
