// See http_server.h.
#include "clients/web/gateway/http_server.h"

#include <openssl/ssl.h>

#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/ssl/context.hpp>
#include <stdexcept>
#include <utility>

#include "clients/web/gateway/http_connection.h"

namespace hapticd::web {

namespace asio = boost::asio;
using boost::system::error_code;
using Tcp = asio::ip::tcp;

namespace {

/// What a socket holds for a slow viewer, bytes: more would only be more of the past.
constexpr int kSendBytes = 128 << 10;

std::optional<asio::ssl::context> tls_context(const ServerOptions& options) {
  if (options.certificate.empty()) return std::nullopt;
  asio::ssl::context tls(asio::ssl::context::tls_server);
  tls.set_options(asio::ssl::context::default_workarounds | asio::ssl::context::no_tlsv1 |
                  asio::ssl::context::no_tlsv1_1);
  error_code error;
  tls.use_certificate_chain_file(options.certificate.string(), error);
  if (error) {
    throw std::runtime_error("--cert " + options.certificate.string() + ": " + error.message() +
                             ". It has to be a certificate in PEM form");
  }
  tls.use_private_key_file(options.private_key.string(), asio::ssl::context::pem, error);
  if (error || SSL_CTX_check_private_key(tls.native_handle()) != 1) {
    throw std::runtime_error("--key-file " + options.private_key.string() + ": " +
                             (error ? error.message() : "not the key of the certificate") +
                             ". It has to be the certificate's key in PEM form");
  }
  return tls;
}

void bind(Tcp::acceptor& acceptor, const ServerOptions& options) {
  const std::string name = options.address + ":" + std::to_string(options.port);
  error_code error;
  const auto address = asio::ip::make_address(options.address, error);
  if (error) throw std::runtime_error("--listen " + name + ": not a numeric address and a port");
  const Tcp::endpoint endpoint(address, options.port);
  acceptor.open(endpoint.protocol(), error);
  if (!error) acceptor.set_option(Tcp::acceptor::reuse_address(true), error);
  if (!error) acceptor.bind(endpoint, error);
  if (!error) acceptor.listen(asio::socket_base::max_listen_connections, error);
  if (error) {
    throw std::runtime_error("--listen " + name + ": " + error.message() +
                             ". Name another address or port of this machine");
  }
}

void accept_next(const std::shared_ptr<HttpServer::Shared>& shared) {
  shared->acceptor.async_accept([shared](const error_code& error, Tcp::socket socket) {
    if (!shared->acceptor.is_open()) return;
    if (!error) {
      error_code ignored;  // A socket without these options serves as well.
      socket.set_option(Tcp::no_delay(true), ignored);
      socket.set_option(asio::socket_base::send_buffer_size(kSendBytes), ignored);
      const asio::ip::address from = remote_address(socket);
      begin_connection(shared, std::move(socket), from);
    }
    accept_next(shared);
  });
}

}  // namespace

HttpServer::Shared::Shared(asio::io_context& context, ServerOptions given, Hub& its_hub)
    : options(std::move(given)),
      hub(its_hub),
      tls(tls_context(options)),
      acceptor(context),
      door({options.most_connections, options.most_of_address}) {
  bind(acceptor, options);
  files = std::make_unique<FileDesk>(context, options.page, options.assets);
}

HttpServer::HttpServer(asio::io_context& context, ServerOptions options, Hub& hub)
    : shared_(std::make_shared<Shared>(context, std::move(options), hub)) {}

HttpServer::~HttpServer() {
  stop();
  // Its threads refer to the context, which connections may outlive this in.
  shared_->files.reset();
}

void HttpServer::start() {
  shared_->files->look();
  accept_next(shared_);
}

void HttpServer::stop() {
  error_code ignored;
  shared_->acceptor.close(ignored);
}

std::uint16_t HttpServer::port() const { return shared_->acceptor.local_endpoint().port(); }

ServerCounters HttpServer::counters() const {
  ServerCounters all = shared_->counters;
  all.door = shared_->door.counters();
  return all;
}

}  // namespace hapticd::web
