#include "core/base/descriptor.h"

#include <fcntl.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <cerrno>
#include <utility>

namespace rigcal {
namespace {

bool IsOpen(int number) {
  return fcntl(number, F_GETFD) != -1;
}

Descriptor OpenNull() {
  return Descriptor(open("/dev/null", O_RDONLY | O_CLOEXEC));
}

TEST(Descriptor, IsClosedWithItsHolder) {
  int number = -1;
  {
    const Descriptor descriptor = OpenNull();
    ASSERT_TRUE(descriptor.Open());
    number = descriptor.Number();
    EXPECT_TRUE(IsOpen(number));
  }
  EXPECT_FALSE(IsOpen(number));
}

TEST(Descriptor, MovesAndClosesWhatItHeld) {
  Descriptor first = OpenNull(), second = OpenNull();
  const int kept = first.Number(), dropped = second.Number();
  second = std::move(first);
  EXPECT_EQ(second.Number(), kept);
  EXPECT_TRUE(IsOpen(kept));
  EXPECT_FALSE(IsOpen(dropped));
  const Descriptor third(std::move(second));
  EXPECT_EQ(third.Number(), kept);
  EXPECT_TRUE(IsOpen(kept));
}

TEST(Descriptor, ClosesOnceAndKeepsErrno) {
  Descriptor descriptor = OpenNull();
  const int number = descriptor.Number();
  errno = EBUSY;
  descriptor.Close();
  EXPECT_EQ(errno, EBUSY);
  EXPECT_FALSE(descriptor.Open());
  EXPECT_FALSE(IsOpen(number));
  const Descriptor other = OpenNull();  // has the free number again
  descriptor.Close();
  EXPECT_TRUE(IsOpen(other.Number()));
}

TEST(Descriptor, OfAFailedOpenIsNone) {
  const Descriptor descriptor(open("/nowhere/at/all", O_RDONLY | O_CLOEXEC));
  EXPECT_FALSE(descriptor.Open());
}

}  // namespace
}  // namespace rigcal
