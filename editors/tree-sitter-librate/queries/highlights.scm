(comment) @comment
(number) @number
"1" @type
(text) @string

; The last pattern that fits decides.
(name) @variable
((name) @constant.builtin
  (#any-of? @constant.builtin "t" "pi"))

(model name: (name) @module)
(param (parameter name: (name) @constant))
(table name: (name) @module)
(index name: (name) @variable.parameter)
(rows name: (name) @variable.parameter)
(rows table: (name) @module)
(field column: (name) @property)

(call function: (name) @function)
(call function: (name) @function.builtin
  (#any-of? @function.builtin
    "sin" "cos" "tan" "asin" "acos" "atan" "atan2" "sinh" "cosh" "tanh" "exp" "ln" "sqrt" "abs" "norm" "dot" "cross"
    "transpose" "mod" "floor" "rot_x" "rot_y" "rot_z" "angular_velocity" "inertia_sphere" "inertia_shell"
    "inertia_cylinder" "inertia_rod" "inertia_box" "inertia_point" "steiner" "about" "rows"))
["sum" "integral"] @function.builtin

(unit_name) @type
(exponent) @number

[
  "model" "param" "coord" "let" "T" "V" "lagrangian" "dissipation" "force" "constraint" "assume" "guess" "equilibrium"
  "period" "table" "draw"
] @keyword
["point" "line" "spring"] @attribute
["in" "where"] @keyword
["and" "or" "not"] @keyword.operator
["=" "==" "!=" "<" "<=" ">" ">=" "+" "-" "*" "/" "^" "'" ".." "±" "+/-"] @operator
["(" ")" "[" "]"] @punctuation.bracket
["," ";" ":" "."] @punctuation.delimiter
