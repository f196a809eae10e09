#include "core/base/descriptor.h"

#include <unistd.h>

#include <cerrno>

namespace rigcal {

Descriptor& Descriptor::operator=(Descriptor&& other) noexcept {
  if (this != &other) {
    Close();
    number_ = std::exchange(other.number_, kNone);
  }
  return *this;
}

void Descriptor::Close() noexcept {
  if (number_ < 0) return;
  const int before = errno;
  close(std::exchange(number_, kNone));  // Linux frees the number even where this fails; a second try could hit another
  errno = before;
}

}  // namespace rigcal
