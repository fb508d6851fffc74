//! All mistakes of a term that can't be worked out, not only the first.

use super::ModelError;
use super::compile::MOST_ERRORS;
use super::names::World;
use super::program::{Op, Program, SumProgram};
use super::run::{Stop, filters, operand_count};
use super::values::Value;
use crate::span::Span;

impl World {
    /// Runs a program that has mistakes to its end, to tell all of them: what could not be worked out
    /// is left out of what uses it.
    pub(super) fn find_mistakes(&mut self, program: &Program, slots: &mut Vec<i64>, mistakes: &mut Vec<ModelError>) {
        let mut stack: Vec<Option<Value>> = Vec::new();
        for (op, span) in &program.ops {
            let operands = stack.split_off(stack.len().saturating_sub(operand_count(op)));
            if let Op::SumOver(sum) = op {
                let before = mistakes.len();
                self.find_mistakes_in_sum(sum, slots, *span, mistakes);
                if mistakes.len() > before {
                    stack.push(None);
                    continue;
                }
            }
            let Some(operands) = operands.into_iter().collect::<Option<Vec<Value>>>() else {
                stack.push(None);
                continue;
            };
            match self.step(op, *span, operands, slots, None) {
                Ok(Some(value)) => stack.push(Some(value)),
                Ok(None) => {}
                Err(Stop::Error(error)) => {
                    if *error != (ModelError::FollowOn {}) && mistakes.len() < MOST_ERRORS {
                        mistakes.push(*error);
                    }
                    stack.push(None);
                }
                Err(Stop::WriteOut) => stack.push(None),
            }
        }
    }

    /// Those of the first term that has any.
    fn find_mistakes_in_sum(
        &mut self,
        sum: &SumProgram,
        slots: &mut Vec<i64>,
        span: Span,
        mistakes: &mut Vec<ModelError>,
    ) {
        let before = mistakes.len();
        let filters = filters(sum);
        let ranges = self.instances::<ModelError>(&sum.binders, &filters, slots, span, |world, slots| {
            world.find_mistakes(&sum.body, slots, mistakes);
            if mistakes.len() > before { Err(ModelError::FollowOn {}) } else { Ok(()) }
        });
        if let Err(error) = ranges
            && error != (ModelError::FollowOn {})
        {
            mistakes.push(error);
        }
    }
}
