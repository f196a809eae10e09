#include "drivers/grbl/serial_line.h"

#include <fcntl.h>
#include <poll.h>
#include <sys/file.h>
#include <sys/ioctl.h>
#include <termios.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <system_error>

namespace rigcal {
namespace {

constexpr int kMostFullSlices = 25;   ///< half a second without a byte taken: at 115200 baud 5000 would have gone
constexpr std::size_t kChunk = 1024;  ///< bytes of one read
constexpr speed_t kBaud = B115200;    ///< of every GRBL 1.1 as it is delivered

std::string ReasonOf(int failure) {
  return std::generic_category().message(failure);
}

tl::unexpected<Error> CannotOpen(const std::string& path, int failure) {
  if (failure == ENOENT || failure == ENODEV || failure == ENXIO) {
    return Fail(ErrorCode::kNotFound, "grbl: {}: there is no such serial device", path);
  }
  if (failure == EACCES) {
    return Fail(ErrorCode::kDevice, "grbl: {}: this user may not open it (group dialout may)", path);
  }
  if (failure == EBUSY) return Fail(ErrorCode::kDevice, "grbl: {}: {}", path, SerialLine::kHeld);
  return Fail(ErrorCode::kDevice, "grbl: {}: cannot be opened: {}", path, ReasonOf(failure));
}

/// Raw bytes. Control lines keep their state when the device is closed (no HUPCL): boards that take a falling DTR for
/// their reset button keep their position from one capture to the next.
Result<void> SetUp(int descriptor, const std::string& path) {
  termios settings{};
  if (tcgetattr(descriptor, &settings) != 0) {
    return Fail(ErrorCode::kBadInput, "grbl: {}: is not a serial device", path);
  }
  cfmakeraw(&settings);
  settings.c_cflag |= CLOCAL | CREAD;
  settings.c_cflag &= ~static_cast<tcflag_t>(CSTOPB | CRTSCTS | HUPCL);
  settings.c_cc[VMIN] = 0;
  settings.c_cc[VTIME] = 0;
  if (cfsetspeed(&settings, kBaud) != 0 || tcsetattr(descriptor, TCSANOW, &settings) != 0) {
    return Fail(ErrorCode::kDevice, "grbl: {}: cannot be set to 115200 baud: {}", path, ReasonOf(errno));
  }
  tcflush(descriptor, TCIOFLUSH);  // what it said to somebody else
  return {};
}

}  // namespace

Result<SerialLine> SerialLine::Open(const std::string& path) {
  Descriptor descriptor(open(path.c_str(), O_RDWR | O_NOCTTY | O_NONBLOCK | O_CLOEXEC));
  if (!descriptor.Open()) return CannotOpen(path, errno);
  if (isatty(descriptor.Number()) == 0) {
    return Fail(ErrorCode::kBadInput, "grbl: {}: is not a serial device", path);
  }
  // The lock keeps out programs that ask for it (root included), the exclusive mode those that do not.
  if (flock(descriptor.Number(), LOCK_EX | LOCK_NB) != 0) return CannotOpen(path, EBUSY);
  if (ioctl(descriptor.Number(), TIOCEXCL) != 0) return CannotOpen(path, errno);
  if (Result<void> set = SetUp(descriptor.Number(), path); !set) return Fail(set.error());
  return SerialLine(std::move(descriptor), path);
}

SerialLine::~SerialLine() {
  if (descriptor_.Open()) ioctl(descriptor_.Number(), TIOCNXCL);  // it stays while anybody else has the device open
}

tl::unexpected<Error> SerialLine::Gone(int failure) const {
  return Fail(ErrorCode::kDevice, "grbl: {}: the serial line is gone: {}", path_, ReasonOf(failure));
}

bool SerialLine::Await(short events) const {
  pollfd waited{.fd = descriptor_.Number(), .events = events, .revents = 0};
  return poll(&waited, 1, kSlice_ms) > 0;
}

Result<void> SerialLine::Write(std::string_view bytes) {
  int full_slices = 0;
  while (!bytes.empty()) {
    const ssize_t written = write(descriptor_.Number(), bytes.data(), bytes.size());
    if (written > 0) {
      bytes.remove_prefix(static_cast<std::size_t>(written));
    } else if (written < 0 && errno == EAGAIN) {
      if (!Await(POLLOUT) && ++full_slices >= kMostFullSlices) {
        return Fail(ErrorCode::kTimeout, "grbl: {}: took no byte for {} ms", path_, kMostFullSlices * kSlice_ms);
      }
    } else if (written == 0 || errno != EINTR) {
      return Gone(written == 0 ? EIO : errno);
    }
  }
  return {};
}

Result<std::optional<std::string>> SerialLine::ReadLine() {
  if (auto line = splitter_.Next()) return line;
  if (!Await(POLLIN)) return std::nullopt;
  std::array<char, kChunk> bytes{};
  const ssize_t count = read(descriptor_.Number(), bytes.data(), bytes.size());
  if (count == 0) return Gone(EIO);  // hung up: after poll promised something, nothing is the end
  if (count < 0 && errno != EAGAIN && errno != EINTR) return Gone(errno);
  if (count > 0) splitter_.Add({bytes.data(), static_cast<std::size_t>(count)});
  return splitter_.Next();
}

}  // namespace rigcal
