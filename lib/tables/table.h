// Tables of scores as LaTeX, Markdown and CSV.
#ifndef PHYSMAS_TABLES_TABLE_H
#define PHYSMAS_TABLES_TABLE_H

#include <string>
#include <vector>

#include "metrics/sets.h"

namespace physmas::tables {

using metrics::Score;

// A number with its format; an invalid one prints as "invalid", an absent one as a dash.
struct Number {
  Score score;
  int decimals = 4;
  bool percent = false;
  bool best = false;
  std::string text() const;
};

// One cell: a text, or one number, or two with a slash between.
struct Cell {
  std::string text;
  std::vector<Number> numbers;
};

struct Table {
  // Columns of one group stand next to each other; a group "" has no heading of its own.
  struct Column {
    std::string group, name;
    std::vector<std::string> parts;  // of two-number cells, for CSV
  };
  struct Row {
    std::string label;
    std::vector<Cell> cells;  // one per column
  };
  std::string name;     // file stem
  std::string corner;   // heading of the row labels
  std::string caption;  // one sentence
  std::vector<Column> columns;
  std::vector<Row> rows;
  bool last_row_apart = false;  // LaTeX: a rule before it, as the paper sets its own method and averages apart

  std::string latex() const;     // a booktabs tabular with its caption
  std::string markdown() const;  // a pipe table under its caption
  std::string csv() const;       // one number per column, all digits; empty where there is none

  bool has_numbers() const;  // valid or invalid: something was measured
};

// Marks the best of every column, number by number.
void mark_columns(Table& table, bool higher_is_better);

// Marks the best valid numbers among these, unless one of them is invalid: then nobody is known to be best.
void mark_best(const std::vector<Number*>& numbers, bool higher_is_better);

}  // namespace physmas::tables

#endif
