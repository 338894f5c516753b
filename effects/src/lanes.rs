//! Runs a lane program on chunks of 64 lanes, so that registers stay in the fastest cache and every operation is one
//! SIMD loop.
//!
//! Every operation acts on each lane alone and is either exactly rounded or implemented here. A lane therefore gives
//! the same bits at any position, for any split of lanes into calls, on every processor.

use super::math;
use super::op::{self, Op};
use super::program::{LaneOp, LaneStep, MOST_REGISTERS, Operand, Program};

/// Lanes that one operation handles at a time.
const CHUNK: usize = 64;

/// Results of an operation on a chunk.
type Register = [f64; CHUNK];

/// Inputs of a lane program.
pub struct LaneInputs<'a> {
    /// Results of the step program.
    pub scalars: &'a [f64],
    /// One slice per input of the program, each with one value per lane.
    pub slices: &'a [&'a [f64]],
    /// Fractional tool cell index of each lane.
    pub tool_cell: &'a [f64],
    /// States of the tool cells.
    pub tool_states: &'a [Vec<f64>],
}

/// Runs `program` over `len` lanes into one slice per output. Returns true if all results are finite.
pub fn run(program: &Program, inputs: &LaneInputs, outputs: &mut [&mut [f64]], len: usize) -> bool {
    let run = Run { program, inputs, outputs, len };
    pulp::Arch::new().dispatch(run)
}

/// Arguments of [`run`] as a type that `pulp` compiles for each instruction set.
struct Run<'a, 'b, 'c> {
    program: &'a Program,
    inputs: &'a LaneInputs<'a>,
    outputs: &'b mut [&'c mut [f64]],
    len: usize,
}

impl pulp::NullaryFnOnce for Run<'_, '_, '_> {
    type Output = bool;

    #[inline(always)]
    fn call(self) -> bool {
        // A few registers are quick to clear; most programs need no more.
        match self.program.registers {
            0..=8 => run_chunks(self, &mut [[0.0; CHUNK]; 8]),
            9..=32 => run_chunks(self, &mut [[0.0; CHUNK]; 32]),
            _ => run_chunks(self, &mut [[0.0; CHUNK]; MOST_REGISTERS]),
        }
    }
}

// Everything below is inlined into the call above, so that it is compiled for the same instruction set.

#[inline(always)]
fn run_chunks(run: Run, registers: &mut [Register]) -> bool {
    let mut all_finite = true;
    let mut start = 0;
    while start < run.len {
        let chunk = Chunk { inputs: run.inputs, start, len: CHUNK.min(run.len - start) };
        for step in &run.program.steps {
            chunk.step(step, registers);
        }
        for (output, operand) in run.outputs.iter_mut().zip(&run.program.outputs) {
            let to = &mut output[start..start + chunk.len];
            match chunk.fetch(*operand, registers) {
                Value::Lanes(lanes) => to.copy_from_slice(lanes),
                Value::One(value) => to.fill(value),
            }
            all_finite &= to.iter().fold(true, |all, x| all & x.is_finite());
        }
        start += chunk.len;
    }
    all_finite
}

#[derive(Clone, Copy)]
enum Value<'a> {
    One(f64),
    Lanes(&'a [f64]),
}

#[derive(Clone, Copy)]
struct Chunk<'a> {
    inputs: &'a LaneInputs<'a>,
    start: usize,
    len: usize,
}

impl<'a> Chunk<'a> {
    #[inline(always)]
    fn fetch<'r>(self, operand: Operand, registers: &'r [Register]) -> Value<'r>
    where
        'a: 'r,
    {
        match operand {
            Operand::Scalar(index) => Value::One(self.inputs.scalars[index as usize]),
            Operand::Input(index) => {
                Value::Lanes(&self.inputs.slices[index as usize][self.start..self.start + self.len])
            }
            Operand::Register(index) => Value::Lanes(&registers[index as usize][..self.len]),
        }
    }

    #[inline(always)]
    fn step(self, step: &LaneStep, registers: &mut [Register]) {
        let (before, rest) = registers.split_at_mut(step.to);
        let Some((to, after)) = rest.split_first_mut() else { return };
        let to = &mut to[..self.len];
        let fetch = |operand: Operand| match operand {
            Operand::Register(index) if index as usize > step.to => {
                self.fetch(Operand::Register(index - step.to as u32 - 1), after)
            }
            other => self.fetch(other, before),
        };
        match step.op {
            LaneOp::ToolCellOver(state) => {
                interpolate(to, &self.inputs.tool_states[state], &self.inputs.tool_cell[self.start..])
            }
            LaneOp::Apply(op) => match op.arity() {
                1 => unary(op, to, fetch(step.arguments[0])),
                2 => binary(op, to, fetch(step.arguments[0]), fetch(step.arguments[1])),
                _ => select(to, step.arguments.map(fetch)),
            },
        }
    }
}

// Macros, because a closure passed to a loop is not compiled for the loop's instruction set.

/// One loop over an argument.
macro_rules! map {
    ($to:ident, $a:ident, $result:expr) => {
        match $a {
            Value::Lanes(lanes) => {
                for (to, &$a) in $to.iter_mut().zip(lanes) {
                    *to = $result;
                }
            }
            Value::One($a) => $to.fill($result),
        }
    };
}

/// One loop over two arguments.
macro_rules! zip {
    ($to:ident, $a:ident, $b:ident, $result:expr) => {
        match ($a, $b) {
            (Value::Lanes(left), Value::Lanes(right)) => {
                for ((to, &$a), &$b) in $to.iter_mut().zip(left).zip(right) {
                    *to = $result;
                }
            }
            (Value::Lanes(left), Value::One($b)) => {
                for (to, &$a) in $to.iter_mut().zip(left) {
                    *to = $result;
                }
            }
            (Value::One($a), Value::Lanes(right)) => {
                for (to, &$b) in $to.iter_mut().zip(right) {
                    *to = $result;
                }
            }
            (Value::One($a), Value::One($b)) => $to.fill($result),
        }
    };
}

#[inline(always)]
fn unary(op: Op, to: &mut [f64], a: Value) {
    match op {
        Op::Neg => map!(to, a, -a),
        Op::Sqrt => map!(to, a, a.sqrt()),
        Op::Exp => map!(to, a, math::exp(a)),
        Op::Log => map!(to, a, math::log(a)),
        Op::Sin => map!(to, a, math::sin(a)),
        Op::Cos => map!(to, a, math::cos(a)),
        Op::Tanh => map!(to, a, math::tanh(a)),
        Op::Abs => map!(to, a, a.abs()),
        Op::Sign => map!(to, a, op::sign(a)),
        _ => unreachable!("{op:?} has more than one argument"),
    }
}

#[inline(always)]
fn binary(op: Op, to: &mut [f64], a: Value, b: Value) {
    match op {
        Op::Add => zip!(to, a, b, a + b),
        Op::Sub => zip!(to, a, b, a - b),
        Op::Mul => zip!(to, a, b, a * b),
        Op::Div => zip!(to, a, b, a / b),
        Op::Pow => zip!(to, a, b, math::pow(a, b)),
        Op::Less => zip!(to, a, b, op::less(a, b)),
        Op::LessEqual => zip!(to, a, b, op::less_equal(a, b)),
        Op::Equal => zip!(to, a, b, op::equal(a, b)),
        Op::Min => zip!(to, a, b, op::min(a, b)),
        Op::Max => zip!(to, a, b, op::max(a, b)),
        _ => unreachable!("{op:?} has not two arguments"),
    }
}

#[inline(always)]
fn select(to: &mut [f64], arguments: [Value; 3]) {
    let mut spread = [[0.0; CHUNK]; 3];
    for (argument, spread) in arguments.iter().zip(&mut spread) {
        match *argument {
            Value::Lanes(lanes) => spread[..lanes.len()].copy_from_slice(lanes),
            Value::One(value) => spread.fill(value),
        }
    }
    let [condition, then, other] = &spread;
    for (((to, &condition), &then), &other) in to.iter_mut().zip(condition).zip(then).zip(other) {
        *to = op::select(condition, then, other);
    }
}

/// Interpolates linearly between the cell centres; constant beyond the outermost.
#[inline(always)]
fn interpolate(to: &mut [f64], cells: &[f64], places: &[f64]) {
    let last = cells.len() - 1;
    for (to, place) in to.iter_mut().zip(places) {
        let place = op::min(op::max(*place, 0.0), last as f64);
        let cell = (place as usize).min(last);
        let next = cells[(cell + 1).min(last)];
        *to = cells[cell] + (place - cell as f64) * (next - cells[cell]);
    }
}
