#include "report/plot.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "report/page.h"

namespace physmas::report {
namespace {

constexpr double kWidth = 460, kHeight = 210, kLeft = 52, kRight = 10, kTop = 12, kBottom = 30;

// A step of 1, 2 or 5 times a power of ten that divides the range into about `parts`.
double nice_step(double range, int parts) {
  const double raw = range / parts, power = std::pow(10, std::floor(std::log10(raw)));
  const double times = raw / power;
  return power * (times < 1.5 ? 1 : times < 3.5 ? 2 : times < 7.5 ? 5 : 10);
}

std::string number(double value) {
  return std::abs(value) < 1e-12 ? "0" : fmt::format("{:.4g}", value);
}

}  // namespace

std::string line_plot(const std::string& title, const std::string& unit, const std::vector<double>& times,
                      const std::vector<Curve>& curves) {
  double low = 0, high = 0;
  for (const Curve& curve : curves) {
    for (const double v : curve.values) {
      if (std::isfinite(v)) low = std::min(low, v), high = std::max(high, v);
    }
  }
  if (times.size() < 2 || !(high > low) || !(times.back() > times.front())) return "";
  const double step = nice_step(high - low, 4);
  low = std::floor(low / step) * step;
  high = std::ceil(high / step) * step;
  const auto x = [&](double t) {
    return kLeft + (kWidth - kLeft - kRight) * (t - times.front()) / (times.back() - times.front());
  };
  const auto y = [&](double v) { return kHeight - kBottom - (kHeight - kTop - kBottom) * (v - low) / (high - low); };
  std::string svg, words, legend;
  for (double v = low; v <= high + step / 2; v += step) {
    svg += fmt::format(
        "<line class=\"grid\" x1=\"{}\" x2=\"{}\" y1=\"{:.1f}\" y2=\"{:.1f}\"/><text x=\"{}\" y=\"{:.1f}\" "
        "text-anchor=\"end\">{}</text>",
        kLeft, kWidth - kRight, y(v), y(v), kLeft - 6, y(v) + 4, number(v));
  }
  const double t_step = nice_step(times.back() - times.front(), 5);
  for (double t = times.front(); t <= times.back() + 1e-9; t += t_step) {
    svg += fmt::format("<text x=\"{:.1f}\" y=\"{}\" text-anchor=\"middle\">{} s</text>", x(t), kHeight - 10, number(t));
  }
  for (size_t k = 0; k < curves.size(); ++k) {
    std::string points;
    bool open = false;
    for (size_t i = 0; i < std::min(times.size(), curves[k].values.size()); ++i) {
      const double v = curves[k].values[i];
      if (!std::isfinite(v)) {
        open = false;
        continue;
      }
      points += fmt::format("{}{:.1f} {:.1f}", open ? "L" : "M", x(times[i]), y(v));
      open = true;
    }
    svg += fmt::format("<path class=\"curve c{}\" d=\"{}\"/>", k % 6, points);
    legend += fmt::format("<span><i class=\"c{}\"></i>{}</span>", k % 6, escaped(curves[k].name));
    if (!curves[k].values.empty())
      words += fmt::format(" {}: at most {}, {} at the end.", curves[k].name,
                           number(*std::max_element(curves[k].values.begin(), curves[k].values.end())),
                           number(curves[k].values.back()));
  }
  return fmt::format(
      "<figure class=\"plot\"><figcaption>{} <small>{}</small></figcaption><svg viewBox=\"0 0 {} {}\" role=\"img\" "
      "aria-label=\"{}.{}\">{}</svg>"
      "<div class=\"legend\">{}</div></figure>\n",
      escaped(title), escaped(unit), kWidth, kHeight, escaped(title), escaped(words), svg, legend);
}

std::string bar_plot(const std::string& title, const std::vector<Bar>& bars) {
  double total = 0;
  for (const Bar& bar : bars) total = std::max(total, bar.start + bar.length);
  if (!(total > 0)) return "";
  constexpr double kRow = 24, kName = 190, kText = 130;
  const double height = kRow * static_cast<double>(bars.size()) + 6, width = 720;
  std::string svg;
  double top = 2;
  for (const Bar& bar : bars) {
    const double scale = (width - kName - kText) / total;
    svg += fmt::format(
        "<text x=\"0\" y=\"{:.0f}\">{}</text><rect class=\"bar\" x=\"{:.1f}\" y=\"{:.0f}\" width=\"{:.1f}\" "
        "height=\"14\" rx=\"3\"/>"
        "<text x=\"{:.1f}\" y=\"{:.0f}\">{}</text>",
        top + 14, escaped(bar.name), kName + scale * bar.start, top + 3, std::max(1.5, scale * bar.length),
        kName + scale * (bar.start + bar.length) + 8, top + 14, escaped(bar.text));
    top += kRow;
  }
  return fmt::format(
      "<figure class=\"plot wide\"><figcaption>{}</figcaption><div class=\"scroll\"><svg viewBox=\"0 0 {} {}\" "
      "role=\"img\" aria-label=\"{}\">{}</svg></div></figure>\n",
      escaped(title), width, height, escaped(title), svg);
}

}  // namespace physmas::report
