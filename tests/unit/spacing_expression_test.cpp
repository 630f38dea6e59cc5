// Formulas: values, precedence, and errors with their place.
#include <gtest/gtest.h>

#include <bit>
#include <cmath>
#include <cstdint>
#include <numbers>
#include <string>
#include <vector>

#include "voropack/expression.h"

namespace voropack {
namespace {

const std::vector<std::string> kNames = {"x", "y"};

double value(const std::string& text, double x = 0, double y = 0) {
  const std::vector<double> at = {x, y};
  return Expression(text, kNames)(at);
}

ExpressionFault fault(const std::string& text) {
  try {
    const Expression expression(text, kNames);
  } catch (const ExpressionError& error) {
    return error.fault();
  }
  ADD_FAILURE() << "accepted: " << text;
  return {};
}

TEST(Expression, FollowsTheUsualPrecedence) {
  EXPECT_EQ(value("1+2*3"), 7);
  EXPECT_EQ(value("(1+2)*3"), 9);
  EXPECT_EQ(value("2^3^2"), 512);
  EXPECT_EQ(value("-2^2"), -4);
  EXPECT_EQ(value("2^-1"), 0.5);
  EXPECT_EQ(value("8/4/2"), 1);
  EXPECT_EQ(value("5-3-1"), 1);
  EXPECT_EQ(value("--3"), 3);
  EXPECT_EQ(value("2*-x", 3), -6);
  EXPECT_EQ(value("1 < 2 "), 1);
  EXPECT_EQ(value("1+1 >= 3"), 0);
  EXPECT_EQ(value(".5e1"), 5);
}

TEST(Expression, KnowsItsFunctionsAndConstants) {
  EXPECT_DOUBLE_EQ(value("sqrt(x^2 + y^2)", 3, 4), 5);
  EXPECT_DOUBLE_EQ(value("hypot(x, y)", 3, 4), 5);
  EXPECT_DOUBLE_EQ(value("pow(x, y)", 3, 4), 81);
  EXPECT_DOUBLE_EQ(value("abs(-x)", 3), 3);
  EXPECT_DOUBLE_EQ(value("exp(log(x))", 3), 3);
  EXPECT_DOUBLE_EQ(value("sin(pi/2) + cos(0) + tan(0)"), 2);
  EXPECT_DOUBLE_EQ(value("log(e)"), 1);
  EXPECT_DOUBLE_EQ(value("asin(sin(x)) + acos(cos(x)) + atan(tan(x))", 0.5), 1.5);
  EXPECT_DOUBLE_EQ(value("atan2(x, y)", 1, -1), 0.75 * std::numbers::pi);
  EXPECT_DOUBLE_EQ(value("tanh(x)*cosh(x)", 0.5), value("sinh(x)", 0.5));
  EXPECT_DOUBLE_EQ(value("min(3, x, y)", 2, 1), 1);
  EXPECT_DOUBLE_EQ(value("max(x)", 2), 2);
  EXPECT_DOUBLE_EQ(value("if(x < y, 10, 20)", 1, 2), 10);
  EXPECT_DOUBLE_EQ(value("if(x == y, 10, 20)", 1, 2), 20);
}

TEST(Expression, DerivativesAgreeWithDifferenceQuotients) {
  for (const std::string text : {"3",
                                 "x",
                                 "y",
                                 "x+y",
                                 "x-2*y",
                                 "x*y",
                                 "x/y",
                                 "x^3",
                                 "x^y",
                                 "2^x",
                                 "pow(x, -2)",
                                 "-x",
                                 "sqrt(x)",
                                 "abs(y-x)",
                                 "exp(x*y)",
                                 "log(x)",
                                 "sin(x)*cos(y)",
                                 "tan(x)",
                                 "asin(x) + acos(x*y)",
                                 "atan(x/y)",
                                 "atan2(x, y)",
                                 "sinh(x)*cosh(y)",
                                 "tanh(x*y)",
                                 "min(x, y, 9)",
                                 "max(x, y)",
                                 "hypot(x, y)",
                                 "if(x < y, x^2, y)",
                                 "(x < y)*x",
                                 "if(x > y, x^2, sin(3*y))",
                                 "((x+1)*(y+(2*(x+(3*(y+(4*x^2)))))))"}) {
    const Expression formula(text, kNames);
    for (std::size_t k = 0; k < 2; ++k) {
      std::vector<double> at = {0.7, 1.3}, after = at, before = at;
      const double h = 1e-5;
      after[k] += h;
      before[k] -= h;
      const double quotient = (formula(after) - formula(before)) / (2 * h);
      EXPECT_NEAR(formula.derivative(at, k), quotient, 1e-8 * (1 + std::abs(quotient))) << text << ", variable " << k;
    }
  }
}

TEST(Expression, ConstantsHaveNoDerivativeWhateverTheyArePutInto) {
  const auto derivative = [](const std::string& text, double x) {
    return Expression(text, kNames).derivative(std::vector<double>{x, 0.0}, 0);
  };
  EXPECT_EQ(derivative("sqrt(0) + x", 2), 1);
  EXPECT_EQ(derivative("x^2", 0), 0);
  EXPECT_EQ(derivative("x^2", -3), -6);
  EXPECT_EQ(derivative("x^0", 0), 0);
  EXPECT_EQ(derivative("hypot(y, 0) + 2*x", 1), 2);
  EXPECT_EQ(derivative("abs(x)", 0), 0);
}

TEST(Expression, ManyPointsAtOnceGiveTheSameBits) {
  constexpr std::size_t kN = 150;  // More than two blocks, and not a whole number of them.
  std::vector<double> x(kN);
  for (std::size_t i = 0; i < kN; ++i) x[i] = -2 + 0.031 * static_cast<double>(i);
  const std::vector<double> y = {0.7};
  const std::vector<Expression::Argument> arguments = {x, y};
  constexpr std::uint64_t kNaN = 1;  // Of NaN, not even the processor promises the bits.
  const auto bits = [](double value) { return std::isnan(value) ? kNaN : std::bit_cast<std::uint64_t>(value); };
  for (const std::string text :
       {"x", "y", "3", "x + y - 2*x/y", "-x^3", "sqrt(x) + log(x)", "exp(x)*sin(y*x) - cos(x)/tan(y)",
        "if(x < 0, abs(x), min(x, y, 1)) + max(x, y)", "hypot(x, y) + (x >= y) - (x != 1)",
        "atan2(x, y) + tanh(x)*atan(y) + sinh(x)/cosh(y)", "asin(x) + acos(y)", "pow(x, y)"}) {
    const Expression formula(text, kNames);
    std::vector<double> values(kN), slopes(kN);
    formula.evaluate(arguments, values);
    for (std::size_t k = 0; k < 2; ++k) {
      formula.differentiate(arguments, k, slopes);
      for (std::size_t i = 0; i < kN; ++i) {
        const std::vector<double> at = {x[i], y[0]};
        EXPECT_EQ(bits(values[i]), bits(formula(at))) << text << " at " << x[i];
        EXPECT_EQ(bits(slopes[i]), bits(formula.derivative(at, k))) << text << " at " << x[i];
      }
    }
  }
}

TEST(Expression, KnowsWhichVariablesItUses) {
  const Expression formula("if(x < 1, 2*x, 3)", kNames);
  EXPECT_TRUE(formula.uses(0));
  EXPECT_FALSE(formula.uses(1));
}

TEST(Expression, DeepFormulasNeedNoMoreThanTheirStack) {
  std::string text = "x";
  for (int i = 0; i < 100; ++i) text = "(1+" + text + ")";
  EXPECT_EQ(value(text, 1), 101);
}

TEST(Expression, RefusesWithReasonAndColumn) {
  EXPECT_EQ(fault("1 + ").column, 5U);
  EXPECT_EQ(fault("1 + * 2").column, 5U);
  EXPECT_EQ(fault("(1").column, 3U);
  EXPECT_EQ(fault("1)").column, 2U);
  EXPECT_EQ(fault("x**2").column, 3U);
  EXPECT_EQ(fault("2 x").column, 3U);
  EXPECT_EQ(fault("").column, 1U);
  EXPECT_EQ(fault("x + sqrt").reason, "function 'sqrt' needs arguments in parentheses");
  EXPECT_EQ(fault("pow(1)").reason, "'pow' takes 2 arguments, not 1");
  EXPECT_EQ(fault("sqrt(1,2)").reason, "'sqrt' takes 1 argument, not 2");
  EXPECT_EQ(fault("1e999").reason, "number out of range");
  EXPECT_EQ(fault("min()").column, 5U);
}

TEST(Expression, SuggestsTheNearestName) {
  EXPECT_EQ(fault("0.1 + sqr(x)").reason, "unknown name 'sqr'; did you mean 'sqrt'?");
  EXPECT_EQ(fault("0.1 + sqr(x)").column, 7U);
  EXPECT_EQ(fault("hypto(x,y)").reason, "unknown name 'hypto'; did you mean 'hypot'?");
  EXPECT_NE(fault("temperature").reason.find("known are x, y, pi"), std::string::npos);
}

TEST(Expression, PointsAtTheFault) {
  EXPECT_EQ(fault("1 + * 2").text("1 + * 2"), "expected a value, found '*' at column 5:\n  1 + * 2\n      ^");
}

TEST(Expression, DeepNestingIsAFaultAndNoOverflow) {
  EXPECT_NE(fault(std::string(100000, '(')).reason.find("nested"), std::string::npos);
  std::string powers = "1";
  for (int i = 0; i < 100000; ++i) powers += "^1";
  EXPECT_NE(fault(powers).reason.find("nested"), std::string::npos);
  EXPECT_EQ(value(std::string(100000, '-') + "1"), 1);
}

}  // namespace
}  // namespace voropack
