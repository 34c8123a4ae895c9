// One connection of a browser until it becomes a viewer's: requests are read and answered one after
// the other. One thread. Not RT.
#pragma once

#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/ssl/context.hpp>
#include <cstddef>
#include <memory>
#include <optional>

#include "clients/web/gateway/http_server.h"

namespace hapticd::web {

/// What a server's connections share.
struct HttpServer::Shared {
  Shared(boost::asio::io_context& context, ServerOptions given, Hub& its_hub);

  ServerOptions options;
  ServerCounters counters;
  Hub& hub;
  std::optional<boost::asio::ssl::context> tls;
  boost::asio::ip::tcp::acceptor acceptor;
  std::size_t connections = 0;  ///< open, viewers included
  std::size_t viewers = 0;
};

/// Serves what comes from `socket`, until it closes.
void begin_connection(const std::shared_ptr<HttpServer::Shared>& shared,
                      boost::asio::ip::tcp::socket socket);

}  // namespace hapticd::web
