// See start_check.h.
#include "server/daemon/start_check.h"

#include <fcntl.h>
#include <linux/magic.h>
#include <sys/vfs.h>
#include <unistd.h>

#include <cerrno>
#include <filesystem>
#include <stdexcept>
#include <system_error>

#include "server/daemon/daemon_options.h"
#include "server/daemon/record_desk.h"
#include "server/network/udp_transport.h"

namespace hapticd {
namespace {

namespace fs = std::filesystem;

std::string said(const fs::path& path, int error) {
  return path.string() + ": " + std::generic_category().message(error);
}

/// Whether what is in `folder` is made by the kernel alone. Permissions do not tell it of root.
bool is_of_kernel(const fs::path& folder) {
  struct statfs info {};
  if (::statfs(folder.c_str(), &info) != 0) return false;
  return info.f_type == PROC_SUPER_MAGIC || info.f_type == SYSFS_MAGIC;
}

}  // namespace

std::string fault_of_new_file(const std::string& path) {
  std::error_code error;
  const fs::path file = fs::absolute(path, error);
  if (error) return said(path, error.value());
  if (!file.has_filename()) return said(file, EISDIR);
  if (fs::exists(fs::symlink_status(file, error))) return said(file, EEXIST);
  // The nearest one that is there: the others are made in it.
  fs::path folder = file.parent_path();
  while (folder.has_relative_path() && !fs::exists(folder, error)) folder = folder.parent_path();
  if (!fs::is_directory(folder, error)) return said(folder, ENOTDIR);
  if (::faccessat(AT_FDCWD, folder.c_str(), W_OK | X_OK, AT_EACCESS) != 0) {
    return said(folder, errno);
  }
  return is_of_kernel(folder) ? said(folder, EPERM) : "";
}

void check_start(const v1::Config& config, const StopPlan& stop) {
  try {
    check_listen(config.listen(), !config.keys().empty());
  } catch (const std::runtime_error& error) {
    throw StartError(kExitAddress, std::string("--listen: ") + error.what());
  }
  check_stop_plan(stop);
  if (config.record().empty()) return;
  const std::string fault = fault_of_new_file(config.record());
  if (!fault.empty()) throw unstarted_recording(fault);
}

}  // namespace hapticd
