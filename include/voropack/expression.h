// Formulas given as text, such as "0.05 + 0.1*sqrt(x^2 + y^2)": parsed once, evaluated often.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <stdexcept>
#include <string>
#include <string_view>
#include <vector>

namespace voropack {

/// What is wrong with a formula. The caller turns it into an error of its own.
struct ExpressionFault {
  std::string reason;      ///< What is wrong, without the place.
  std::size_t column = 1;  ///< 1-based byte of the text.

  /// The reason, the column, the text and a caret below the column.
  [[nodiscard]] std::string text(std::string_view formula) const;
};

class ExpressionError : public std::runtime_error {
 public:
  ExpressionError(ExpressionFault fault, std::string_view formula)
      : std::runtime_error(fault.text(formula)), fault_(std::move(fault)) {}
  [[nodiscard]] const ExpressionFault& fault() const { return fault_; }

 private:
  ExpressionFault fault_;
};

/// A compiled formula. Evaluation is a pure function and safe to call from many threads.
///
///     comparison = sum [("<" | "<=" | ">" | ">=" | "==" | "!=") sum]      1 or 0
///     sum        = product {("+" | "-") product}
///     product    = unary {("*" | "/") unary}
///     unary      = {"+" | "-"} power
///     power      = primary ["^" unary]                                    right associative, so -x^2 = -(x^2)
///     primary    = number | variable | "pi" | "e" | name "(" comparison {"," comparison} ")" | "(" comparison ")"
///
/// Functions: sqrt abs exp log (natural) sin cos tan asin acos atan sinh cosh tanh, of one argument; pow hypot
/// atan2(y, x) of two; min max of one or more; if(condition, then, else), where every value but 0 is true.
class Expression {
 public:
  /// Throws ExpressionError. A variable hides a constant of the same name.
  Expression(std::string_view text, std::span<const std::string> variables);

  /// The value for the given values of the variables, in the order in which they were named. May be infinite or NaN.
  [[nodiscard]] double operator()(std::span<const double> values) const;

  /// Whether the formula mentions the variable of that number.
  [[nodiscard]] bool uses(std::size_t variable) const;

  /// The derivative with respect to the variable of that number, by forward differentiation: exact up to rounding.
  /// Comparisons count as constant; at a kink it is the derivative of the branch that is taken, and 0 for abs.
  [[nodiscard]] double derivative(std::span<const double> values, std::size_t variable) const;

  /// The values of a variable at many points: one for each, or one for all of them.
  using Argument = std::span<const double>;

  /// Values and derivatives at many points at once: several times faster, and the same to the bit.
  void evaluate(std::span<const Argument> arguments, std::span<double> results) const;
  void differentiate(std::span<const Argument> arguments, std::size_t variable, std::span<double> results) const;

 private:
  friend class ExpressionParser;
  friend struct ExpressionTangent;
  enum class Op : std::uint8_t {
    kNumber,
    kVariable,
    kAdd,
    kSubtract,
    kMultiply,
    kDivide,
    kPower,
    kNegate,
    kLess,
    kLessEqual,
    kGreater,
    kGreaterEqual,
    kEqual,
    kNotEqual,
    kSqrt,
    kAbs,
    kExp,
    kLog,
    kSin,
    kCos,
    kTan,
    kAsin,
    kAcos,
    kAtan,
    kSinh,
    kCosh,
    kTanh,
    kMin,
    kMax,
    kHypot,
    kAtan2,
    kIf
  };
  /// An instruction of a stack machine.
  struct Step {
    Op op;
    std::uint32_t variable = 0;
    double number = 0;
  };
  static double apply(Op op, double a, double b);
  static double apply_derivative(Op op, double a, double b, double da, double db);
  template <class T>
  static void apply_to_all(Op op, const T* a, const T* b, std::size_t n, T* results);
  template <class T, std::size_t kWidth, class ArgumentAt>
  void run(const ArgumentAt& argument_at, std::size_t n, std::size_t variable, T* stack) const;
  template <class T>
  T run_once(std::span<const double> values, std::size_t variable) const;
  template <class T, class Take>
  void run_blocks(std::span<const Argument> arguments, std::size_t n, std::size_t variable, const Take& take) const;

  std::vector<Step> program_;
  std::size_t stack_size_ = 0;  // What `program_` needs.
};

}  // namespace voropack
