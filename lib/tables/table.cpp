#include "tables/table.h"

#include <fmt/format.h>

#include <algorithm>

#include "base/error.h"
#include "base/printable.h"

namespace physmas::tables {
namespace {

// Names of methods come from outside: in every form of the table they are text and nothing else, on one line.
constexpr size_t kMostBytes = 1000;  // of a name

std::string latex_text(const std::string& text) {
  std::string out;
  for (const char c : one_line(text, kMostBytes)) {
    if (c == '\\') {
      out += "\\textbackslash{}";
    } else if (c == '~' || c == '^') {
      out += fmt::format("\\{}{{}}", c);
    } else if (std::string("&%$#_{}").find(c) != std::string::npos) {
      out += fmt::format("\\{}", c);
    } else {
      out += c;
    }
  }
  return out;
}

std::string markdown_text(const std::string& text) {
  std::string out;
  for (const char c : one_line(text, kMostBytes)) {
    // Raw HTML, then what Markdown itself reads as more than a letter.
    if (c == '<') {
      out += "&lt;";
    } else if (c == '>') {
      out += "&gt;";
    } else if (c == '&') {
      out += "&amp;";
    } else {
      if (std::string("\\`*_[]|~").find(c) != std::string::npos) out += '\\';
      out += c;
    }
  }
  return out;
}

// A field that a spreadsheet would take for a formula gets an apostrophe.
std::string csv_text(const std::string& name) {
  std::string text = printable(name);
  if (!text.empty() && std::string("=+-@").find(text[0]) != std::string::npos) text = "'" + text;
  if (text.find_first_of(",\"\n\r") == std::string::npos) return text;
  std::string quoted = "\"";
  for (const char c : text) quoted += c == '"' ? "\"\"" : std::string(1, c);
  return quoted + "\"";
}

std::string cell_text(const Cell& cell) {
  std::string text = cell.text;
  for (const Number& n : cell.numbers) text += (text.empty() ? "" : "/") + n.text();
  return text;
}

bool is_best(const Cell& cell) {
  return !cell.numbers.empty() &&
         std::all_of(cell.numbers.begin(), cell.numbers.end(), [](const Number& n) { return n.best; });
}

std::string full_name(const Table::Column& column) {
  return column.group.empty() ? column.name : column.group + " " + column.name;
}

}  // namespace

std::string Number::text() const {
  if (score.state == Score::State::absent) return "–";
  if (!score.valid()) return "invalid";
  return fmt::format("{:.{}f}{}", score.value, decimals, percent ? "%" : "");
}

std::string Table::latex() const {
  std::string text = "\\begin{table}\n\\centering\n\\begin{tabular}{@{}l" + std::string(columns.size(), 'c') + "@{}}\n";
  text += "\\toprule\n";
  const bool grouped = std::any_of(columns.begin(), columns.end(), [](const Column& c) { return !c.group.empty(); });
  if (grouped) {
    std::string heads = fmt::format("\\multirow{{2}}{{*}}{{{}}}", latex_text(corner)), rules;
    for (size_t i = 0; i < columns.size();) {
      size_t end = i + 1;
      while (end < columns.size() && columns[end].group == columns[i].group) ++end;
      heads += fmt::format(" & \\multicolumn{{{}}}{{c}}{{{}}}", end - i, latex_text(columns[i].group));
      rules += fmt::format("\\cmidrule(lr){{{}-{}}}", i + 2, end + 1);
      i = end;
    }
    text += heads + " \\\\\n" + rules + "\n";
  } else {
    text += latex_text(corner);
  }
  for (const Column& column : columns)
    text += " & " + (column.name == "CLIPsim" ? std::string("CLIP$_{sim}$") : latex_text(column.name));
  text += " \\\\\n\\midrule\n";
  for (const Row& row : rows) {
    if (last_row_apart && rows.size() > 1 && &row == &rows.back()) text += "\\midrule\n";
    text += latex_text(row.label);
    for (const Cell& cell : row.cells) {
      const std::string value = latex_text(cell_text(cell));
      text += is_best(cell) ? " & \\textbf{" + value + "}" : " & " + value;
    }
    text += " \\\\\n";
  }
  return text + "\\bottomrule\n\\end{tabular}\n\\caption{" + latex_text(caption) + "}\n\\end{table}\n";
}

std::string Table::markdown() const {
  std::string text = markdown_text(caption) + "\n\n| " + markdown_text(corner) + " |", rule = "|---|";
  for (const Column& column : columns) {
    text += " " + markdown_text(full_name(column)) + " |";
    rule += "---|";
  }
  text += "\n" + rule + "\n";
  for (const Row& row : rows) {
    text += "| " + markdown_text(row.label) + " |";
    for (const Cell& cell : row.cells) {
      const std::string value = markdown_text(cell_text(cell));
      text += is_best(cell) ? " **" + value + "** |" : " " + value + " |";
    }
    text += "\n";
  }
  return text;
}

std::string Table::csv() const {
  std::string text = csv_text(corner);
  for (const Column& column : columns) {
    if (column.parts.empty()) text += "," + csv_text(full_name(column));
    for (const std::string& part : column.parts) text += "," + csv_text(full_name(column) + " " + part);
  }
  text += "\n";
  for (const Row& row : rows) {
    text += csv_text(row.label);
    for (const Cell& cell : row.cells) {
      if (cell.numbers.empty()) text += "," + csv_text(cell.text);
      for (const Number& n : cell.numbers) text += n.score.valid() ? fmt::format(",{}", n.score.value) : ",";
    }
    text += "\n";
  }
  return text;
}

void mark_best(const std::vector<Number*>& numbers, bool higher_is_better) {
  const Number* best = nullptr;
  for (const Number* n : numbers) {
    if (n->score.state == Score::State::invalid) return;
    if (!n->score.valid()) continue;
    if (best == nullptr || (higher_is_better ? n->score.value > best->score.value : n->score.value < best->score.value))
      best = n;
  }
  if (best == nullptr) return;
  const double value = best->score.value;
  for (Number* n : numbers) n->best = n->score.valid() && n->score.value == value;
}

bool Table::has_numbers() const {
  for (const Row& row : rows) {
    for (const Cell& cell : row.cells) {
      for (const Number& number : cell.numbers) {
        if (number.score.state != Score::State::absent) return true;
      }
    }
  }
  return false;
}

void mark_columns(Table& table, bool higher_is_better) {
  for (size_t c = 0; c < table.columns.size(); ++c) {
    for (size_t part = 0; !table.rows.empty() && part < table.rows[0].cells[c].numbers.size(); ++part) {
      std::vector<Number*> numbers;
      for (Table::Row& row : table.rows) numbers.push_back(&row.cells[c].numbers[part]);
      mark_best(numbers, higher_is_better);
    }
  }
}

}  // namespace physmas::tables
