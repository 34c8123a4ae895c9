// What is read from disks for browsers, beside the loop that serves them: a disk may be slow, and a
// file of 60 MB takes its time to be hashed. Folders of assets are looked through by one thread,
// everything else is read by another, so that neither the page nor a file that is under way waits
// for a large folder. Not RT.
#pragma once

#include <boost/asio/io_context.hpp>
#include <boost/asio/thread_pool.hpp>
#include <cstddef>
#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "clients/web/gateway/asset_store.h"
#include "clients/web/gateway/page_folder.h"

namespace hapticd::web {

/// A file that was asked for; nothing: there is none.
using FoundFile = std::function<void(std::optional<PageFile>)>;
/// A block of a file; nothing: it has changed, and is not to be had any more.
using ReadBlock = std::function<void(std::optional<std::string>)>;

class FileDesk {
 public:
  /// All answers come from `context`, later; it outlives the desk.
  FileDesk(boost::asio::io_context& context, std::filesystem::path page,
           std::vector<std::filesystem::path> assets);
  /// Waits for what is being read, and forgets what still waits.
  ~FileDesk();
  FileDesk(const FileDesk&) = delete;
  FileDesk& operator=(const FileDesk&) = delete;

  /// Reads the folders of assets, so that nobody has to wait for that later.
  void look();
  /// As AssetStore::find().
  void asset(std::string hash, FoundFile done);
  /// As PageFolder::find().
  void page(std::string target, bool gzip, FoundFile done);
  /// As CheckedFile::block().
  void block(std::shared_ptr<const CheckedFile> file, std::size_t index, ReadBlock done);

 private:
  template <typename Work, typename Done>
  void run(boost::asio::thread_pool& thread, Work work, Done done);

  boost::asio::io_context& context_;
  AssetStore assets_;
  PageFolder page_;
  boost::asio::thread_pool finder_{1};  ///< assets_ is its own
  boost::asio::thread_pool reader_{1};  ///< page_ is its own
};

}  // namespace hapticd::web
