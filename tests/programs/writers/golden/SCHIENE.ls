/PROG  SCHIENE
/ATTR
OWNER		= MNEDITOR;
COMMENT		= "elastocal";
PROG_SIZE	= 0;
FILE_NAME	= ;
VERSION		= 0;
LINE_COUNT	= 90;
MEMORY_SIZE	= 0;
PROTECT		= READ_WRITE;
TCD:  STACK_SIZE	= 0,
      TASK_PRIORITY	= 50,
      TIME_SLICE	= 0,
      BUSY_LAMP_OFF	= 0,
      ABORT_REQUEST	= 0,
      PAUSE_REQUEST	= 0;
DEFAULT_GROUP	= 1,*,*,*,*;
CONTROL_CODE	= 00000000 00000000;
/MN
   1:  !Calibration campaign: 3 ;
   2:  !experiments in 2 configurations. ;
   3:  !Made by elastocal 0.1.0 from ;
   4:  !'Schiene - Zelle 3 (Sud)', plan ;
   5:  !sha256 0123456789abcdef. ;
   6:  !Robot: arm on a rail. Joint ;
   7:  !values: deg, mm, as in the ;
   8:  !model. ;
   9:  !Forces act at the load point of ;
  10:  !the tool, in the axes of the ;
  11:  !robot base. ;
  12:  !SAFETY: check this program at ;
  13:  !low speed in manual mode first. ;
  14:  !Motions between the points are ;
  15:  !not checked for collisions by ;
  16:  !this file. ;
  17:  !Set the payload of the empty ;
  18:  !calibration tool and leave it ;
  19:  !so, loaded and unloaded: the ;
  20:  !controller must not compensate ;
  21:  !what is to be measured. ;
  22:  !elastocal program 000000000000 ;
  23:  UFRAME_NUM=0 ;
  24:  UTOOL_NUM=1 ;
  25:  !to H0 ;
  26:J P[1] 25% FINE    ;
  27:  !to AP1 ;
  28:J P[2] 25% FINE    ;
  29:  !to P1 ;
  30:J P[3] 25% FINE    ;
  31:  WAIT   2.00(sec) ;
  32:  MESSAGE[Experiment 1/3: pose 1.] ;
  33:  MESSAGE[NO load. Measure M1.] ;
  34:  PAUSE ;
  35:  MESSAGE[Experiment 1/3: apply] ;
  36:  MESSAGE[374.63 N, Fx 100 Fy] ;
  37:  MESSAGE[-200.5 Fz -300.25 N.] ;
  38:  PAUSE ;
  39:  WAIT   2.00(sec) ;
  40:  MESSAGE[Experiment 1/3: pose 1.] ;
  41:  MESSAGE[LOADED. Measure M1.] ;
  42:  PAUSE ;
  43:  MESSAGE[Experiment 1/3: take the] ;
  44:  MESSAGE[load off. The robot] ;
  45:  MESSAGE[moves next.] ;
  46:  PAUSE ;
  47:  !to AP2 ;
  48:J P[4] 25% FINE    ;
  49:  !to P2 ;
  50:J P[5] 25% FINE    ;
  51:  WAIT   2.00(sec) ;
  52:  MESSAGE[Experiment 2/3: pose 2.] ;
  53:  MESSAGE[NO load. Measure M1.] ;
  54:  PAUSE ;
  55:  MESSAGE[Experiment 2/3: hang 10] ;
  56:  MESSAGE[kg, Fx 0 Fy 0 Fz -98.07] ;
  57:  MESSAGE[N, Tx 1.5 Ty 0 Tz -2] ;
  58:  MESSAGE[N.m.] ;
  59:  PAUSE ;
  60:  WAIT   2.00(sec) ;
  61:  MESSAGE[Experiment 2/3: pose 2.] ;
  62:  MESSAGE[LOADED. Measure M1.] ;
  63:  PAUSE ;
  64:  MESSAGE[Experiment 2/3: take the] ;
  65:  MESSAGE[load off. The robot] ;
  66:  MESSAGE[moves next.] ;
  67:  PAUSE ;
  68:  !to AP2 ;
  69:J P[4] 25% FINE    ;
  70:  !to P2 ;
  71:J P[5] 25% FINE    ;
  72:  WAIT   2.00(sec) ;
  73:  MESSAGE[Experiment 3/3: pose 2.] ;
  74:  MESSAGE[NO load. Measure M1.] ;
  75:  PAUSE ;
  76:  MESSAGE[Experiment 3/3: hang 10] ;
  77:  MESSAGE[kg, Fx 0 Fy 0 Fz -98.07] ;
  78:  MESSAGE[N, Tx 1.5 Ty 0 Tz -2] ;
  79:  MESSAGE[N.m.] ;
  80:  PAUSE ;
  81:  WAIT   2.00(sec) ;
  82:  MESSAGE[Experiment 3/3: pose 2.] ;
  83:  MESSAGE[LOADED. Measure M1.] ;
  84:  PAUSE ;
  85:  MESSAGE[Experiment 3/3: take the] ;
  86:  MESSAGE[load off. The robot] ;
  87:  MESSAGE[moves next.] ;
  88:  PAUSE ;
  89:  !to H0 ;
  90:J P[1] 25% FINE    ;
/POS
P[1]{
   GP1:
	UF : 0, UT : 1,	
	J1=    0.0000 deg,	J2=    0.0000 deg,	J3=    0.0000 deg,
	J4=    0.0000 deg,	J5=    0.0000 deg,	J6=    0.0000 deg,
	E1=    0.0000  mm
};
P[2]{
   GP1:
	UF : 0, UT : 1,	
	J1=    5.2296 deg,	J2=  -11.9592 deg,	J3=   16.6887 deg,
	J4=  -23.4183 deg,	J5=   28.1479 deg,	J6=  -34.8775 deg,
	E1= 1233.5679  mm
};
P[3]{
   GP1:
	UF : 0, UT : 1,	
	J1=    5.7296 deg,	J2=  -11.4592 deg,	J3=   17.1887 deg,
	J4=  -22.9183 deg,	J5=   28.6479 deg,	J6=  -34.3775 deg,
	E1= 1234.5679  mm
};
P[4]{
   GP1:
	UF : 0, UT : 1,	
	J1=   62.5254 deg,	J2=   68.2549 deg,	J3=  -74.9845 deg,
	J4=   79.7141 deg,	J5=  -86.4437 deg,	J6=  177.1169 deg,
	E1=  499.0000  mm
};
P[5]{
   GP1:
	UF : 0, UT : 1,	
	J1=   63.0254 deg,	J2=   68.7549 deg,	J3=  -74.4845 deg,
	J4=   80.2141 deg,	J5=  -85.9437 deg,	J6=  177.6169 deg,
	E1=  500.0000  mm
};
/END
