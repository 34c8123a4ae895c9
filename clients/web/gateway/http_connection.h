// One connection of a browser until it becomes a viewer's: requests are read and answered one after
// the other. One thread. Not RT.
#pragma once

#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/address.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/ssl/context.hpp>
#include <cstddef>
#include <memory>
#include <optional>

#include "clients/web/gateway/door.h"
#include "clients/web/gateway/file_desk.h"
#include "clients/web/gateway/http_server.h"
#include "clients/web/gateway/wait_list.h"

namespace hapticd::web {

/// What a server's connections share.
struct HttpServer::Shared {
  Shared(boost::asio::io_context& context, ServerOptions given, Hub& its_hub);

  ServerOptions options;
  ServerCounters counters;
  Hub& hub;
  std::optional<boost::asio::ssl::context> tls;
  boost::asio::ip::tcp::acceptor acceptor;
  std::unique_ptr<FileDesk> files;
  Door door;  ///< viewers included; who waits for its peer, or for a disk, waits there
  std::size_t viewers = 0;
  std::size_t anonymous = 0;  ///< viewers without the token
  WaitList lookers;           ///< of them, since they were last heard
};

/// Where a connection comes from; IPv4 addresses as such.
[[nodiscard]] boost::asio::ip::address remote_address(const boost::asio::ip::tcp::socket& socket);

/// Serves what comes from `socket`, a connection with `from`, until it closes; closes it where
/// there is no place for it.
void begin_connection(const std::shared_ptr<HttpServer::Shared>& shared,
                      boost::asio::ip::tcp::socket socket, const boost::asio::ip::address& from);

}  // namespace hapticd::web
