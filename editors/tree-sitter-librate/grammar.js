/**
 * The model language, `.lag`, for editors: as `grammar/librate.pest` has it, which decides.
 */

/// <reference types="tree-sitter-cli/dsl" />

const list = rule => seq(rule, repeat(seq(',', rule)));

/** What can't be a name. */
const STATEMENTS = [
  'model', 'param', 'coord', 'let', 'T', 'V', 'lagrangian', 'dissipation', 'force', 'constraint', 'assume', 'guess',
  'equilibrium', 'period', 'table', 'draw',
];
const WORDS = [...STATEMENTS, 'sum', 'integral', 'in', 'where', 'and', 'or', 'not'];
/** The tesla, the volt and the inch. */
const UNITS = ['T', 'V', 'in'];

const PRECEDENCE = { or: 1, and: 2, not: 3, compare: 4, add: 5, multiply: 6, negate: 7, power: 8, postfix: 9 };

module.exports = grammar({
  name: 'librate',

  extras: $ => [/[ \t\r\n]/, $.comment],

  word: $ => $.name,

  reserved: {
    global: () => WORDS,
    units: () => WORDS.filter(word => !UNITS.includes(word)),
    columns: () => [],
  },

  rules: {
    file: $ => repeat(choice($._statement, ';')),

    comment: () => token(seq('#', /[^\n]*/)),
    name: () => /[\p{L}_][\p{L}\p{Nd}_]*/,
    number: () => /[0-9]+(\.[0-9]+)?([eE][+-]?[0-9]+)?/,
    text: () => /"[^"\r\n]*"/,

    // ---- statements ---------------------------------------------------------------------------

    _statement: $ => choice(
      $.model, $.param, $.coord, $.let, $.kinetic, $.potential, $.lagrangian, $.dissipation, $.force, $.constraint,
      $.assume, $.guess, $.equilibrium, $.period, $.table, $.draw,
    ),

    model: $ => seq('model', field('name', $.name)),
    param: $ => seq('param', list($.parameter)),
    coord: $ => seq('coord', list($.declaration)),
    let: $ => seq('let', $._declared, '=', $._expression),
    kinetic: $ => seq('T', '=', $._expression),
    potential: $ => seq('V', '=', $._expression),
    lagrangian: $ => seq('lagrangian', '=', $._expression),
    dissipation: $ => seq('dissipation', '=', $._expression),
    force: $ => seq('force', $._declared, '=', $._expression),
    // `constraint [a, b][1] = 0` begins with a vector: only brackets with `in` hold indices.
    constraint: $ => seq('constraint', optional(alias($._named_indices, $.indices)), $._expression, '=', $._expression),
    assume: $ => seq('assume', list($._expression)),
    guess: $ => seq('guess', $._point, '=', $._expression),
    equilibrium: $ => seq('equilibrium', $._point, '=', $._expression),
    period: $ => seq('period', $._expression),
    table: $ => seq('table', field('name', $.name), '=', field('path', $.text)),

    draw: $ => seq(
      'draw', choice('point', 'line', 'spring'), optional(alias($._named_indices, $.indices)), list($._expression),
    ),

    parameter: $ => seq($._declared, optional(seq('=', $._expression, optional($.uncertainty)))),
    declaration: $ => $._declared,
    uncertainty: $ => seq(choice('±', '+/-'), $._expression),

    _declared: $ => seq(field('name', $.name), optional($.indices), optional($._unit_part)),
    _point: $ => seq(field('name', $.name), optional($.indices), optional("'"), optional($._unit_part)),

    // ---- indices ------------------------------------------------------------------------------

    indices: $ => seq('[', list($._index), optional($.filter), ']'),
    _named_indices: $ => seq('[', $._named_index, repeat(seq(',', $._index)), optional($.filter), ']'),
    filter: $ => seq('where', $._expression),

    _index: $ => choice($._named_index, $._expression, $.range),
    _named_index: $ => choice($.rows, $.index),
    rows: $ => seq(field('name', $.name), 'in', field('table', $.name)),
    index: $ => seq(field('name', $.name), 'in', $.range),
    range: $ => seq($._expression, '..', $._expression),

    // ---- expressions --------------------------------------------------------------------------

    // `not` stands only where a condition begins, so that `a + not b` is no expression.
    _expression: $ => choice(alias($._or, $.binary), alias($._and, $.binary), $._condition),
    _or: $ => prec.left(PRECEDENCE.or, seq($._expression, 'or', $._expression)),
    _and: $ => prec.left(PRECEDENCE.and, seq($._expression, 'and', $._expression)),
    _condition: $ => choice($.not, $._term),
    not: $ => prec(PRECEDENCE.not, seq('not', $._condition)),

    _term: $ => choice($.binary, $.negation, $.number, $._primary),
    binary: $ => choice(
      ...[['compare', '=='], ['compare', '!='], ['compare', '<'], ['compare', '<='], ['compare', '>'], ['compare', '>='],
        ['add', '+'], ['add', '-'], ['multiply', '*'], ['multiply', '/']]
        .map(([level, sign]) => prec.left(PRECEDENCE[level], seq($._term, field('operator', sign), $._term))),
      prec.right(PRECEDENCE.power, seq($._term, field('operator', '^'), $._term)),
    ),
    negation: $ => prec(PRECEDENCE.negate, seq('-', $._term)),

    _primary: $ => choice($.name, $.call, $.parenthesis, $.sum, $.vector, $.derivative, $.member, $.field),
    call: $ => prec(PRECEDENCE.postfix, seq(field('function', $.name), '(', optional(list($._expression)), ')')),
    parenthesis: $ => seq('(', $._expression, ')'),
    vector: $ => seq('[', list($._expression), ']'),
    sum: $ => seq(
      choice('sum', 'integral'), '(', list($._named_index), optional($.filter), ',', field('body', $._expression), ')',
    ),
    derivative: $ => prec(PRECEDENCE.postfix, seq($._primary, "'")),
    member: $ => prec(PRECEDENCE.postfix, seq($._primary, '[', list($._expression), ']')),
    // Behind a point any word is the name of a column.
    field: $ => prec(PRECEDENCE.postfix, seq($._primary, '.', field('column', reserved('columns', $.name)))),

    // ---- units --------------------------------------------------------------------------------

    _unit_part: $ => seq(':', $.unit),
    unit: $ => prec.left(seq($._unit_factor, repeat(seq(choice('*', '/'), $._unit_factor)))),
    _unit_factor: $ => seq(
      choice('1', alias(reserved('units', $.name), $.unit_name), seq('(', $.unit, ')')), optional(seq('^', $.exponent)),
    ),
    exponent: $ => choice(
      seq(optional('-'), /[0-9]+/), seq('(', optional('-'), /[0-9]+/, optional(seq('/', /[0-9]+/)), ')'),
    ),
  },
});
