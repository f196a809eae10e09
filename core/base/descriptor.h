#pragma once

#include <utility>

namespace rigcal {

/// An open file descriptor, closed by whoever holds it last. Moved, never copied.
class Descriptor {
 public:
  Descriptor() = default;
  /// Takes over `number`, as open(2) gave it; a negative one is none.
  explicit Descriptor(int number) : number_(number) {}
  Descriptor(Descriptor&& other) noexcept : number_(std::exchange(other.number_, kNone)) {}
  Descriptor& operator=(Descriptor&& other) noexcept;
  Descriptor(const Descriptor&) = delete;
  Descriptor& operator=(const Descriptor&) = delete;
  ~Descriptor() { Close(); }

  [[nodiscard]] int Number() const { return number_; }
  [[nodiscard]] bool Open() const { return number_ >= 0; }
  /// Closes it now. errno stays as it is.
  void Close() noexcept;

 private:
  static constexpr int kNone = -1;
  int number_ = kNone;
};

}  // namespace rigcal
