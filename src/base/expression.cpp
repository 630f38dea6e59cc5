#include "voropack/expression.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <charconv>
#include <cmath>
#include <numbers>
#include <type_traits>

#include "base/names.h"

namespace voropack {

namespace {

/// Nesting allowed in a formula: far more than anybody writes, far less than what the call stack holds.
constexpr int kMaxDepth = 200;
/// Excerpts in messages show this much of the formula on each side of the fault.
constexpr std::size_t kExcerpt = 60;
/// Programs that need no more than this are evaluated without allocating.
constexpr std::size_t kSmallStack = 32;
/// Points that a program is run for at once: enough to make its steps cheap, few enough to stay in the cache.
constexpr std::size_t kBlock = 64;

bool is_name_start(char c) { return std::isalpha(static_cast<unsigned char>(c)) != 0 || c == '_'; }
bool is_name_char(char c) { return is_name_start(c) || std::isdigit(static_cast<unsigned char>(c)) != 0; }

}  // namespace

std::string ExpressionFault::text(std::string_view formula) const {
  const std::size_t at = std::min(column - 1, formula.size());
  const std::size_t begin = at > kExcerpt ? at - kExcerpt : 0;
  std::string excerpt(formula.substr(begin, 2 * kExcerpt));
  // One byte of the excerpt is one column, or the caret would be off.
  for (char& c : excerpt)
    if (std::isprint(static_cast<unsigned char>(c)) == 0) c = '?';
  return fmt::format("{} at column {}:\n  {}\n  {:>{}}", reason, column, excerpt, '^', at - begin + 1);
}

/// Recursive descent; emits the program in postfix order.
class ExpressionParser {
 public:
  ExpressionParser(std::string_view text, std::span<const std::string> variables, Expression& target)
      : text_(text), variables_(variables), target_(target) {}

  void parse() {
    comparison();
    if (peek() != '\0' || at_ < text_.size()) fail(fmt::format("unexpected '{}'", shown(text_[at_])), at_);
  }

 private:
  using Op = Expression::Op;
  struct Function {
    std::string_view name;
    Op op;
    std::size_t least, most;  ///< Number of arguments.
  };
  static constexpr std::size_t kAnyNumber = 1000;
  static constexpr std::array<Function, 19> kFunctions = {{{"sqrt", Op::kSqrt, 1, 1},
                                                           {"abs", Op::kAbs, 1, 1},
                                                           {"exp", Op::kExp, 1, 1},
                                                           {"log", Op::kLog, 1, 1},
                                                           {"sin", Op::kSin, 1, 1},
                                                           {"cos", Op::kCos, 1, 1},
                                                           {"tan", Op::kTan, 1, 1},
                                                           {"asin", Op::kAsin, 1, 1},
                                                           {"acos", Op::kAcos, 1, 1},
                                                           {"atan", Op::kAtan, 1, 1},
                                                           {"sinh", Op::kSinh, 1, 1},
                                                           {"cosh", Op::kCosh, 1, 1},
                                                           {"tanh", Op::kTanh, 1, 1},
                                                           {"min", Op::kMin, 1, kAnyNumber},
                                                           {"max", Op::kMax, 1, kAnyNumber},
                                                           {"pow", Op::kPower, 2, 2},
                                                           {"hypot", Op::kHypot, 2, 2},
                                                           {"atan2", Op::kAtan2, 2, 2},
                                                           {"if", Op::kIf, 3, 3}}};

  [[noreturn]] void fail(std::string reason, std::size_t at) const {
    throw ExpressionError({std::move(reason), at + 1}, text_);
  }
  static char shown(char c) { return std::isprint(static_cast<unsigned char>(c)) != 0 ? c : '?'; }

  char peek() {
    while (at_ < text_.size() && std::isspace(static_cast<unsigned char>(text_[at_])) != 0) ++at_;
    return at_ < text_.size() ? text_[at_] : '\0';
  }
  bool accept(std::string_view token) {
    if (peek() == '\0' || text_.substr(at_, token.size()) != token) return false;
    at_ += token.size();
    return true;
  }
  void expect(char c, std::string_view what) {
    if (!accept(std::string_view(&c, 1))) fail(fmt::format("expected '{}' {}", c, what), at_);
  }
  void enter() {
    if (++depth_ > kMaxDepth) fail(fmt::format("nested more than {} deep", kMaxDepth), at_);
  }
  void leave() { --depth_; }

  void emit(Op op, std::size_t pops, double number = 0, std::uint32_t variable = 0) {
    target_.program_.push_back({op, variable, number});
    stack_ = stack_ - pops + 1;
    target_.stack_size_ = std::max(target_.stack_size_, stack_);
  }

  void comparison() {
    // Longest first, so that "<=" is not read as "<".
    static constexpr std::array<std::pair<std::string_view, Op>, 6> kOperators = {{{"<=", Op::kLessEqual},
                                                                                   {">=", Op::kGreaterEqual},
                                                                                   {"==", Op::kEqual},
                                                                                   {"!=", Op::kNotEqual},
                                                                                   {"<", Op::kLess},
                                                                                   {">", Op::kGreater}}};
    enter();
    sum();
    for (const auto& [token, op] : kOperators) {
      if (!accept(token)) continue;
      sum();
      emit(op, 2);
      break;
    }
    leave();
  }

  void sum() {
    product();
    for (;;) {
      if (accept("+")) {
        product();
        emit(Op::kAdd, 2);
      } else if (accept("-")) {
        product();
        emit(Op::kSubtract, 2);
      } else {
        return;
      }
    }
  }

  void product() {
    unary();
    for (;;) {
      if (accept("*")) {
        if (peek() == '*') fail("unexpected '*'; a power is written '^'", at_);
        unary();
        emit(Op::kMultiply, 2);
      } else if (accept("/")) {
        unary();
        emit(Op::kDivide, 2);
      } else {
        return;
      }
    }
  }

  void unary() {
    bool negative = false;
    for (;;) {
      if (accept("-"))
        negative = !negative;
      else if (!accept("+"))
        break;
    }
    power();
    if (negative) emit(Op::kNegate, 1);
  }

  void power() {
    primary();
    if (!accept("^")) return;
    enter();
    unary();
    leave();
    emit(Op::kPower, 2);
  }

  void primary() {
    const char c = peek();
    if (c == '\0') fail("expected a value", at_);
    if (accept("(")) {
      comparison();
      expect(')', "to close a parenthesis");
      return;
    }
    if (std::isdigit(static_cast<unsigned char>(c)) != 0 || c == '.') {
      number();
      return;
    }
    if (!is_name_start(c)) fail(fmt::format("expected a value, found '{}'", shown(c)), at_);
    const std::size_t begin = at_;
    while (at_ < text_.size() && is_name_char(text_[at_])) ++at_;
    name(text_.substr(begin, at_ - begin), begin);
  }

  void number() {
    double value = 0;
    const auto [end, error] = std::from_chars(text_.data() + at_, text_.data() + text_.size(), value);
    if (error == std::errc::result_out_of_range) fail("number out of range", at_);
    if (error != std::errc()) fail("not a number", at_);
    at_ = static_cast<std::size_t>(end - text_.data());
    emit(Op::kNumber, 0, value);
  }

  void name(std::string_view word, std::size_t begin) {
    if (peek() == '(') {
      for (const Function& function : kFunctions)
        if (function.name == word) return call(function, begin);
    }
    for (std::size_t i = 0; i < variables_.size(); ++i)
      if (variables_[i] == word) return emit(Op::kVariable, 0, 0, static_cast<std::uint32_t>(i));
    if (word == "pi") return emit(Op::kNumber, 0, std::numbers::pi);
    if (word == "e") return emit(Op::kNumber, 0, std::numbers::e);
    std::vector<std::string> known(variables_.begin(), variables_.end());
    known.insert(known.end(), {"pi", "e"});
    for (const Function& function : kFunctions) {
      if (function.name == word) fail(fmt::format("function '{}' needs arguments in parentheses", word), begin);
      known.emplace_back(function.name);
    }
    const std::string near = nearest_name(word, known);
    const std::string hint = near.empty() ? "known are " + join_names(known) : fmt::format("did you mean '{}'?", near);
    fail(fmt::format("unknown name '{}'; {}", word, hint), begin);
  }

  void call(const Function& function, std::size_t begin) {
    expect('(', "after a function");
    std::size_t count = 0;
    if (peek() == ')') fail("expected a value", at_);
    do {
      comparison();
      ++count;
      // Of more than two, fold from the left.
      if (count > 1 && function.most == kAnyNumber) emit(function.op, 2);
    } while (accept(","));
    expect(')', "to end the arguments of a function");
    if (count < function.least || count > function.most)
      fail(fmt::format("'{}' takes {} argument{}, not {}", function.name, function.least,
                       function.least == 1 ? "" : "s", count),
           begin);
    if (function.most != kAnyNumber) emit(function.op, function.most);
  }

  std::string_view text_;
  std::span<const std::string> variables_;
  Expression& target_;
  std::size_t at_ = 0;
  std::size_t stack_ = 0;
  int depth_ = 0;
};

Expression::Expression(std::string_view text, std::span<const std::string> variables) {
  ExpressionParser(text, variables, *this).parse();
}

double Expression::apply(Op op, double a, double b) {
  switch (op) {
    case Op::kAdd:
      return a + b;
    case Op::kSubtract:
      return a - b;
    case Op::kMultiply:
      return a * b;
    case Op::kDivide:
      return a / b;
    case Op::kPower:
      return std::pow(a, b);
    case Op::kLess:
      return a < b ? 1 : 0;
    case Op::kLessEqual:
      return a <= b ? 1 : 0;
    case Op::kGreater:
      return a > b ? 1 : 0;
    case Op::kGreaterEqual:
      return a >= b ? 1 : 0;
    case Op::kEqual:
      return a == b ? 1 : 0;
    case Op::kNotEqual:
      return a != b ? 1 : 0;
    case Op::kMin:
      return std::fmin(a, b);
    case Op::kMax:
      return std::fmax(a, b);
    case Op::kHypot:
      return std::hypot(a, b);
    case Op::kAtan2:
      return std::atan2(a, b);
    case Op::kNegate:
      return -b;
    case Op::kSqrt:
      return std::sqrt(b);
    case Op::kAbs:
      return std::abs(b);
    case Op::kExp:
      return std::exp(b);
    case Op::kLog:
      return std::log(b);
    case Op::kSin:
      return std::sin(b);
    case Op::kCos:
      return std::cos(b);
    case Op::kTan:
      return std::tan(b);
    case Op::kAsin:
      return std::asin(b);
    case Op::kAcos:
      return std::acos(b);
    case Op::kAtan:
      return std::atan(b);
    case Op::kSinh:
      return std::sinh(b);
    case Op::kCosh:
      return std::cosh(b);
    case Op::kTanh:
      return std::tanh(b);
    default:
      return b;
  }
}

/// The derivative of `apply(op, a, b)` where a and b have the derivatives da and db. A factor that is 0 wins over one
/// that is infinite: a constant has no derivative, whatever it is put into.
double Expression::apply_derivative(Op op, double a, double b, double da, double db) {
  const auto times = [](double slope, double tangent) { return tangent == 0 ? 0 : slope * tangent; };
  switch (op) {
    case Op::kAdd:
      return da + db;
    case Op::kSubtract:
      return da - db;
    case Op::kMultiply:
      return times(b, da) + times(a, db);
    case Op::kDivide:
      return times(1 / b, da) - times(a / (b * b), db);
    case Op::kPower:
      return (da == 0 || b == 0 ? 0 : b * std::pow(a, b - 1) * da) + (db == 0 ? 0 : std::pow(a, b) * std::log(a) * db);
    case Op::kMin:
      return std::isnan(b) || a <= b ? da : db;
    case Op::kMax:
      return std::isnan(b) || a >= b ? da : db;
    case Op::kHypot:
      return times(a / std::hypot(a, b), da) + times(b / std::hypot(a, b), db);
    case Op::kAtan2:
      return times(b / (a * a + b * b), da) - times(a / (a * a + b * b), db);
    case Op::kNegate:
      return -db;
    case Op::kSqrt:
      return times(0.5 / std::sqrt(b), db);
    case Op::kAbs:
      return b == 0 ? 0 : std::copysign(1.0, b) * db;
    case Op::kExp:
      return times(std::exp(b), db);
    case Op::kLog:
      return times(1 / b, db);
    case Op::kSin:
      return times(std::cos(b), db);
    case Op::kCos:
      return times(-std::sin(b), db);
    case Op::kTan:
      return times(1 + std::tan(b) * std::tan(b), db);
    case Op::kAsin:
      return times(1 / std::sqrt(1 - b * b), db);
    case Op::kAcos:
      return times(-1 / std::sqrt(1 - b * b), db);
    case Op::kAtan:
      return times(1 / (1 + b * b), db);
    case Op::kSinh:
      return times(std::cosh(b), db);
    case Op::kCosh:
      return times(std::sinh(b), db);
    case Op::kTanh:
      return times(1 - std::tanh(b) * std::tanh(b), db);
    default:  // Comparisons.
      return 0;
  }
}

/// A value with its derivative, as an entry of the stack; a plain double is one without.
struct ExpressionTangent {
  double value = 0, slope = 0;

  using Op = Expression::Op;
  static ExpressionTangent apply(Op op, const ExpressionTangent& a, const ExpressionTangent& b) {
    return {Expression::apply(op, a.value, b.value),
            Expression::apply_derivative(op, a.value, b.value, a.slope, b.slope)};
  }
  static double apply(Op op, double a, double b) { return Expression::apply(op, a, b); }
  static double value_of(double a) { return a; }
  static double value_of(const ExpressionTangent& a) { return a.value; }
  static void set(double& target, double value, bool) { target = value; }
  static void set(ExpressionTangent& target, double value, bool is_variable) {
    target = {value, is_variable ? 1.0 : 0.0};
  }
};

/// Loops of their own for what the processor does to several numbers at once.
template <class T>
void Expression::apply_to_all(Op op, const T* a, const T* b, std::size_t n, T* results) {
  const auto each = [=](auto function) {
    for (std::size_t i = 0; i < n; ++i) results[i] = function(a[i], b[i]);
  };
  if constexpr (std::is_same_v<T, double>) {
    switch (op) {
      case Op::kAdd:
        return each([](double x, double y) { return x + y; });
      case Op::kSubtract:
        return each([](double x, double y) { return x - y; });
      case Op::kMultiply:
        return each([](double x, double y) { return x * y; });
      case Op::kDivide:
        return each([](double x, double y) { return x / y; });
      case Op::kNegate:
        return each([](double, double y) { return -y; });
      default:
        break;
    }
  }
  each([op](const T& x, const T& y) { return ExpressionTangent::apply(op, x, y); });
}

/// Runs the program for n points, at most kWidth, step by step. `stack` has kWidth entries for each value of the stack
/// machine; the results are the first n of it. Of a function of one argument, only the second counts.
template <class T, std::size_t kWidth, class ArgumentAt>
void Expression::run(const ArgumentAt& argument_at, std::size_t n, std::size_t variable, T* stack) const {
  T* top = stack;  // Behind the last value.
  for (const Step& step : program_) {
    switch (step.op) {
      case Op::kNumber:
        for (std::size_t i = 0; i < n; ++i) ExpressionTangent::set(top[i], step.number, false);
        top += kWidth;
        break;
      case Op::kVariable:
        for (std::size_t i = 0; i < n; ++i)
          ExpressionTangent::set(top[i], argument_at(step.variable, i), step.variable == variable);
        top += kWidth;
        break;
      case Op::kNegate:
      case Op::kSqrt:
      case Op::kAbs:
      case Op::kExp:
      case Op::kLog:
      case Op::kSin:
      case Op::kCos:
      case Op::kTan:
      case Op::kAsin:
      case Op::kAcos:
      case Op::kAtan:
      case Op::kSinh:
      case Op::kCosh:
      case Op::kTanh:
        apply_to_all(step.op, top - kWidth, top - kWidth, n, top - kWidth);
        break;
      case Op::kIf:
        top -= 2 * kWidth;
        for (std::size_t i = 0; i < n; ++i) {
          T& condition = *(top - kWidth + i);
          condition = ExpressionTangent::value_of(condition) != 0 ? top[i] : top[kWidth + i];
        }
        break;
      default:
        top -= kWidth;
        apply_to_all(step.op, top - kWidth, top, n, top - kWidth);
    }
  }
}

template <class T>
T Expression::run_once(std::span<const double> values, std::size_t variable) const {
  std::array<T, kSmallStack> small;
  std::vector<T> large(stack_size_ > kSmallStack ? stack_size_ : 0);
  T* const stack = large.empty() ? small.data() : large.data();
  stack[0] = T{};  // Programs are never empty, which the compiler cannot know.
  run<T, 1>([&](std::size_t k, std::size_t) { return values[k]; }, 1, variable, stack);
  return stack[0];
}

template <class T, class Take>
void Expression::run_blocks(std::span<const Argument> arguments, std::size_t n, std::size_t variable,
                            const Take& take) const {
  std::vector<T> stack(stack_size_ * kBlock);
  for (std::size_t begin = 0; begin < n; begin += kBlock) {
    const std::size_t size = std::min(kBlock, n - begin);
    const auto argument_at = [&](std::size_t k, std::size_t i) {
      return arguments[k].size() == 1 ? arguments[k][0] : arguments[k][begin + i];
    };
    run<T, kBlock>(argument_at, size, variable, stack.data());
    for (std::size_t i = 0; i < size; ++i) take(begin + i, stack[i]);
  }
}

double Expression::operator()(std::span<const double> values) const { return run_once<double>(values, 0); }

double Expression::derivative(std::span<const double> values, std::size_t variable) const {
  return run_once<ExpressionTangent>(values, variable).slope;
}

void Expression::evaluate(std::span<const Argument> arguments, std::span<double> results) const {
  run_blocks<double>(arguments, results.size(), 0, [&](std::size_t i, double value) { results[i] = value; });
}

void Expression::differentiate(std::span<const Argument> arguments, std::size_t variable,
                               std::span<double> results) const {
  run_blocks<ExpressionTangent>(arguments, results.size(), variable,
                                [&](std::size_t i, const ExpressionTangent& entry) { results[i] = entry.slope; });
}

bool Expression::uses(std::size_t variable) const {
  return std::any_of(program_.begin(), program_.end(),
                     [&](const Step& step) { return step.op == Op::kVariable && step.variable == variable; });
}

}  // namespace voropack
