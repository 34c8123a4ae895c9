// See file_desk.h.
#include "clients/web/gateway/file_desk.h"

#include <boost/asio/post.hpp>
#include <exception>
#include <utility>

#include "clients/library/client.h"

namespace hapticd::web {

namespace asio = boost::asio;

FileDesk::FileDesk(asio::io_context& context, std::filesystem::path page,
                   std::vector<std::filesystem::path> assets)
    : context_(context), assets_(std::move(assets)), page_(std::move(page)) {}

FileDesk::~FileDesk() {
  finder_.stop();
  reader_.stop();
  finder_.join();
  reader_.join();
}

template <typename Work, typename Done>
void FileDesk::run(asio::thread_pool& thread, Work work, Done done) {
  asio::post(thread, [this, work = std::move(work), done = std::move(done)]() mutable {
    decltype(work()) result{};
    try {
      result = work();
    } catch (const std::exception&) {
      // No memory, or a folder that went meanwhile: as if there were no such file.
    }
    // What `done` holds belongs to the loop, and ends there: nothing of it may stay here.
    asio::post(context_, [done = std::exchange(done, nullptr),
                          result = std::move(result)]() mutable { done(std::move(result)); });
  });
}

void FileDesk::look() {
  asio::post(finder_, [this] {
    try {
      assets_.look();
    } catch (const std::exception&) {
      // It is looked through again when a file is asked for.
    }
  });
}

void FileDesk::asset(std::string hash, FoundFile done) {
  auto work = [this, hash = std::move(hash)]() -> std::optional<PageFile> {
    auto file = assets_.find(hash, client::monotonic_now_ns());
    if (file == nullptr) return std::nullopt;
    return PageFile{"application/octet-stream", false, false, true, std::move(file)};
  };
  run(finder_, std::move(work), std::move(done));
}

void FileDesk::page(std::string target, bool gzip, FoundFile done) {
  auto work = [this, target = std::move(target), gzip] { return page_.find(target, gzip); };
  run(reader_, std::move(work), std::move(done));
}

void FileDesk::block(std::shared_ptr<const CheckedFile> file, std::size_t index, ReadBlock done) {
  run(
      reader_, [file = std::move(file), index] { return file->block(index); }, std::move(done));
}

}  // namespace hapticd::web
