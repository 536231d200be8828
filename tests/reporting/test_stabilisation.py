import numpy as np

from modallab.identification.selection.diagram import IN_FREQUENCY, NEW, STABLE, StabilisationData
from modallab.reporting.figures import style
from modallab.reporting.figures.stabilisation import MOST_ORDERS, stabilisation_panels


def diagram(orders=100, inputs=2):
    order = np.repeat(np.arange(2, orders + 2), 3)
    lines = np.linspace(1, 100, 50)
    curves = np.geomspace(1, 10, 50) * np.array([[1.0], [0.1]])[:inputs]
    return StabilisationData(
        order=order,
        frequency_hz=np.tile([20.0, 50.0, 80.0], orders),
        damping_ratio=np.full(order.size, 0.01),
        standing=np.tile([STABLE, IN_FREQUENCY, NEW], orders),
        held_hz=np.array([20.0]),
        line_hz=lines,
        cmif=curves,
        mmif=curves / 20,
    )


def test_every_panel_has_units_and_marks_the_modes():
    figure = stabilisation_panels(diagram(), np.array([20.0, 50.0]))
    assert [axes.get_title(loc="left") for axes in figure.axes] == ["Stabilisation diagram", "CMIF", "Multivariate MIF"]
    for axes in figure.axes:
        assert "[" in axes.get_xlabel()
        assert "[" in axes.get_ylabel()
        dashed = [line for line in axes.lines if line.get_linestyle() == "--"]
        assert [line.get_xdata()[0] for line in dashed] == [20.0, 50.0]


def test_marks_stand_where_the_poles_do_and_many_orders_are_thinned():
    poles = stabilisation_panels(diagram(), np.array([20.0])).axes[0]
    stable = next(line for line in poles.lines if line.get_marker() == "o")
    assert set(stable.get_xdata()) == {20.0}
    assert stable.get_color() == style.MEASURED
    assert len(stable.get_ydata()) <= MOST_ORDERS
    assert min(stable.get_ydata()) == 2
    few = stabilisation_panels(diagram(orders=9), np.array([20.0])).axes[0]
    assert len(next(line for line in few.lines if line.get_marker() == "o").get_ydata()) == 9


def test_one_input_has_a_plain_mif():
    assert stabilisation_panels(diagram(inputs=1), np.array([20.0])).axes[2].get_title(loc="left") == "MIF"
